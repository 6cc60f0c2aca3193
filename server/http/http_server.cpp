#include "http/http_server.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "http/problem.h"
#include "http/unix_socket.h"
#include "store/job_state.h"

namespace probebake {
namespace {

constexpr const char* kRequestId = "X-Request-Id";
/// What a busy service asks for, until it may have a thread again.
constexpr int kRetrySeconds = 2;
/// A client that is refused for want of threads gets this long to read that.
constexpr std::chrono::milliseconds kRefusalTime{20};
/// Short answers that are under way get this long where a drain has no more time.
constexpr std::chrono::milliseconds kLastAnswers{500};

/// What went wrong inside with the request that this thread answers; for the log only.
thread_local std::string internal_cause;

std::string new_request_id() { return "r-" + new_job_id().substr(2, 16); }

std::string what_of(const std::exception_ptr& exception) {
    try {
        std::rethrow_exception(exception);
    } catch (const std::exception& error) {
        return error.what();
    } catch (...) {
        return "unknown";
    }
}

/// Has connections served where they were accepted: a pool of our own stands behind it.
class NoQueue : public httplib::TaskQueue {
  public:
    explicit NoQueue(ConnectionPool& pool) : pool_(pool) {}
    void enqueue(std::function<void()> pass_on) override { pass_on(); }
    void shutdown() override { pool_.stop(); }

  private:
    ConnectionPool& pool_;
};

}  // namespace

class HttpServer::Library : public httplib::Server {
  public:
    Library(const HttpServer::Options& options, HttpServer::Handler handler, Log log)
        : options_(options),
          handler_(std::move(handler)),
          log_(std::move(log)),
          pool_(options.pool, {[this](int socket) { serve(socket); },
                               [this](int socket) { return refuse(socket); }}) {
        configure();
        bind();
        listener_ = std::jthread([this] {
            listen_after_bind();  // returns when all that was taken is answered
            const std::lock_guard lock(mutex_);
            listening_ = false;
            changed_.notify_all();
        });
        while (!is_running() && listening_) std::this_thread::yield();
    }
    ~Library() override { drain(std::chrono::milliseconds(0)); }

    void drain(std::chrono::milliseconds time) {
        std::unique_lock lock(mutex_);
        // Not stop(), upon which the library breaks all downloads off.
        if (!std::exchange(draining_, true)) {
            ::shutdown(svr_sock_, SHUT_RDWR);
            if (options_.socket) ::unlink(options_.socket->c_str());
        }
        changed_.wait_for(lock, std::max(time, kLastAnswers),
                          [&] { return !listening_ || hurry_ || cut_off_; });
        cut_off_ = true;
        for (const Connection* connection : open_) connection->cut_off();
    }
    void hurry() {
        const std::lock_guard lock(mutex_);
        hurry_ = true;
        changed_.notify_all();
    }
    int port() const { return port_; }
    bool listening() const { return listening_; }

  private:
    /// A connection that drain() can cut off.
    class Open {
      public:
        Open(Library& library, const Connection& connection)
            : library_(library), connection_(connection) {
            const std::lock_guard lock(library_.mutex_);
            library_.open_.insert(&connection_);
            if (library_.cut_off_) connection_.cut_off();
        }
        ~Open() {
            const std::lock_guard lock(library_.mutex_);
            library_.open_.erase(&connection_);
        }
        Open(const Open&) = delete;
        Open& operator=(const Open&) = delete;

      private:
        Library& library_;
        const Connection& connection_;
    };

    /// Called by the library with every socket that it accepted.
    bool process_and_close_socket(socket_t socket) override {
        pool_.add(socket);
        return true;
    }

    void configure() {
        new_task_queue = [this] { return new NoQueue(pool_); };
        // The library would set SO_REUSEPORT: a second service could take half of the clients.
        set_socket_options([](socket_t socket) {
            const int yes = 1;
            ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
        });
        set_tcp_nodelay(true);
        set_keep_alive_max_count(1);
        set_payload_max_length(
            std::max(options_.guard.max_body_bytes, options_.guard.max_upload_bytes));
        set_default_headers({{"Accept-Ranges", "none"},
                             {"Cache-Control", "no-store"},
                             {"X-Content-Type-Options", "nosniff"}});
        // One handler for everything: paths are matched by the router, not by regular expressions.
        const char* any = "[\\s\\S]*";
        const auto handle = [this](const httplib::Request& request, httplib::Response& response) {
            handler_(request, response, nullptr);
        };
        Get(any, handle);
        Post(any, handle);
        Put(kUploadPattern,
            [this](const httplib::Request& request, httplib::Response& response,
                   const httplib::ContentReader& upload) { handler_(request, response, &upload); });
        Put(any, handle);
        Patch(any, handle);
        Delete(any, handle);
        Options(any, handle);
        set_exception_handler([](const httplib::Request& request, httplib::Response& response,
                                 const std::exception_ptr& exception) {
            const Problem problem = problem_of(exception);
            if (problem.status == 500) internal_cause = what_of(exception);
            answer_problem(problem, request, response);
        });
        set_error_handler([](const httplib::Request& request, httplib::Response& response) {
            if (response.has_header("Content-Type")) return;
            answer_problem({.status = response.status,
                            .code = "malformed-http",
                            .detail = "the request could not be read, or not in time"},
                           request, response);
        });
        set_post_routing_handler([](const httplib::Request& request, httplib::Response& response) {
            response.set_header(kRequestId, request_id_of(request));
            // 304 has no body: a length here would have a client wait for one.
            if (response.status == 304) response.headers.erase("Content-Length");
        });
    }

    void bind() {
        if (options_.socket) {
            svr_sock_ = listen_on_unix_socket(*options_.socket);
            return;
        }
        const bool bound = options_.port == 0 ? (port_ = bind_to_any_port(options_.host)) > 0
                                              : bind_to_port(options_.host, options_.port);
        if (!bound) {
            throw std::runtime_error("cannot listen on " + options_.host + ":" +
                                     std::to_string(options_.port) +
                                     ", is the port in use or the address not ours?");
        }
        if (options_.port != 0) port_ = options_.port;
        // The library's backlog of 5 makes bursts of clients wait for a second and more.
        ::listen(svr_sock_, kBacklog);
    }

    void serve(int socket) {
        const auto start = std::chrono::steady_clock::now();
        RequestLog line{.request_id = new_request_id()};
        Connection connection(socket, options_.connection);
        const Open open(*this, connection);
        internal_cause.clear();
        try {
            answer(connection, line);
        } catch (...) {
            const std::exception_ptr exception = std::current_exception();
            const Problem problem = problem_of(exception);
            if (problem.status == 500) internal_cause = what_of(exception);
            if (connection.bytes_sent() == 0) {
                connection.send(raw_response(problem, line.request_id));
            }
        }
        line.cause = internal_cause;
        line.status = connection.status();
        line.bytes_sent = connection.bytes_sent();
        line.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (!line.method.empty() || line.status != 0) log_(line);
        if (line.status != 0) connection.finish();
    }

    void answer(Connection& connection, RequestLog& line) {
        line.peer = connection.peer();
        const std::string head = connection.read_head();
        if (head.empty()) return;
        // For the log, before anything about it is believed.
        line.method = head.substr(0, std::min<size_t>(head.find(' '), 16));
        GuardedHead guarded = guard_head(head, options_.guard, line.request_id);
        line.method = guarded.method;
        line.target = guarded.target;
        if (options_.socket) line.peer = guarded.real_ip;  // only the proxy reaches the socket
        connection.feed(std::move(guarded.for_library), guarded.body_bytes);
        bool closed = false;
        process_request(connection, true, closed, nullptr);
    }

    /// Sends without waiting; the answer is small enough for any socket's buffer.
    std::function<void()> refuse(int socket) {
        ConnectionLimits limits = options_.connection;
        limits.answer_time = std::chrono::milliseconds(0);
        limits.linger_time = kRefusalTime;
        const auto connection = std::make_shared<Connection>(socket, limits);
        const std::string id = new_request_id();
        connection->send(raw_response({.status = 503,
                                       .code = "too-many-connections",
                                       .detail = "too many connections at once",
                                       .retry_after_seconds = kRetrySeconds},
                                      id));
        connection->hang_up();
        return [this, connection, id] {
            connection->finish();
            log_({.request_id = id,
                  .peer = connection->peer(),
                  .status = connection->status(),
                  .bytes_sent = connection->bytes_sent()});
        };
    }

    const HttpServer::Options options_;
    const HttpServer::Handler handler_;
    const Log log_;
    std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable changed_;  // listening_, hurry_
    std::set<const Connection*> open_;
    bool draining_ = false;
    bool hurry_ = false;
    bool cut_off_ = false;

    ConnectionPool pool_;
    int port_ = 0;
    std::atomic<bool> listening_{true};
    std::jthread listener_;
};

HttpServer::HttpServer(const Options& options, Handler handler, Log log)
    : library_(std::make_unique<Library>(options, std::move(handler), std::move(log))) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return library_->port(); }

bool HttpServer::listening() const { return library_->listening(); }

void HttpServer::drain(std::chrono::milliseconds time) { library_->drain(time); }

void HttpServer::hurry() { library_->hurry(); }

std::string request_id_of(const httplib::Request& request) {
    return request.get_header_value(kRequestId);
}

void answer_problem(const Problem& problem, const httplib::Request& request,
                    httplib::Response& response) {
    response.status = problem.status;
    response.set_content(dump_json(write_problem(problem, request_id_of(request))) + "\n",
                         kProblemType);
    if (problem.retry_after_seconds) {
        response.set_header("Retry-After", std::to_string(*problem.retry_after_seconds));
    }
    if (problem.authenticate) response.set_header("WWW-Authenticate", "Bearer");
    if (!problem.allow.empty()) response.set_header("Allow", problem.allow);
}

}  // namespace probebake
