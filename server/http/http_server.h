// HttpServer: cpp-httplib behind a guard.
//
//   accept ─► ConnectionPool ─► head read within limits ─► guard_head ─► cpp-httplib ─► handler
//
// The library parses a head that the guard wrote and formats answers; sockets, limits, time-outs,
// overload and errors are handled here. One request per connection. Every answer carries
// X-Request-Id; every request is told to `log` once, when it has been answered.
#pragma once

#include <httplib.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "http/connection.h"
#include "http/connection_pool.h"
#include "http/guard.h"
#include "http/problem.h"

namespace probebake {

/// One request as the log shows it. Method and target are the client's words.
struct RequestLog {
    std::string request_id;
    std::string peer;
    std::string method;
    std::string target;
    int status = 0;  // 0: the client went before it was answered
    uint64_t bytes_sent = 0;
    double seconds = 0.0;
    std::string cause;  // of an internal error, or why it broke off; never shown to the client
};

class HttpServer {
  public:
    struct Options {
        std::string host = "127.0.0.1";
        int port = 8080;  // 0: any free one
        /// A unix socket instead of host and port.
        std::optional<std::filesystem::path> socket;
        GuardLimits guard;
        ConnectionLimits connection;
        ConnectionPool::Options pool;
    };
    /// `upload` reads the body of a request that brings a scene (is_upload), bit by bit; of any
    /// other request it is null, and the body is in the request.
    using Handler = std::function<void(const httplib::Request&, httplib::Response&,
                                       const httplib::ContentReader* upload)>;
    using Log = std::function<void(const RequestLog&)>;

    /// Listens when it returns. Throws std::runtime_error where the address cannot be had. Handler
    /// and log are called from several threads; what the handler throws becomes a problem.
    HttpServer(const Options& options, Handler handler, Log log);
    ~HttpServer();

    int port() const;  // 0 with a unix socket
    /// False once the socket does not accept any more.
    bool listening() const;
    /// Takes no more connections and answers what was taken, for at most this long; what is still
    /// going on then is cut off, however slow the client. Threads are waited for by the destructor.
    void drain(std::chrono::milliseconds time);
    /// Ends the time of a drain() now.
    void hurry();

  private:
    class Library;
    std::unique_ptr<Library> library_;
};

/// The number of a request, as in X-Request-Id.
std::string request_id_of(const httplib::Request& request);

/// Answers with a problem.
void answer_problem(const Problem& problem, const httplib::Request& request,
                    httplib::Response& response);

}  // namespace probebake
