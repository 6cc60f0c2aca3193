// Answers that are made while they are sent: events, and all files of a job in one archive.
#include <archive.h>
#include <archive_entry.h>

#include "http/api.h"
#include "http/query.h"
#include "io/io_error.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kUnitPage = 100;
constexpr size_t kChunkBytes = size_t{64} << 10;

std::string event(const std::string& name, const std::string& id, const Json& data) {
    return "event: " + name + "\nid: " + id + "\ndata: " + dump_json(data) + "\n\n";
}

/// An answer that is made while it is sent. HTTP/1.0 knows no chunks: there it ends with the
/// connection.
void answer_stream(const char* type, httplib::ContentProviderWithoutLength provider,
                   const httplib::Request& request, httplib::Response& response) {
    if (request.version == "HTTP/1.0") {
        response.set_content_provider(type, std::move(provider));
    } else {
        response.set_chunked_content_provider(type, std::move(provider));
    }
}

/// Thrown for a file that is not as it was baked.
class DamagedFile : public IoError {
  public:
    DamagedFile(const std::string& name, int64_t unit) : IoError(name, "is damaged"), unit_(unit) {}
    int64_t unit() const { return unit_; }

  private:
    int64_t unit_;
};

/// A ustar archive that is written into an answer.
class TarStream {
  public:
    explicit TarStream(httplib::DataSink& sink) : sink_(sink), tar_(::archive_write_new()) {
        ::archive_write_set_format_pax_restricted(tar_);
        ::archive_write_set_bytes_per_block(tar_, static_cast<int>(kChunkBytes));
        ::archive_write_open(tar_, this, nullptr, &TarStream::write, nullptr);
    }
    ~TarStream() { ::archive_write_free(tar_); }
    TarStream(const TarStream&) = delete;
    TarStream& operator=(const TarStream&) = delete;

    void add(const std::string& name, const OpenFile& file) {
        begin(name, file.size_bytes());
        std::vector<char> buffer(kChunkBytes);
        for (uint64_t at = 0; at < file.size_bytes();) {
            const size_t n = file.read_at(at, buffer);
            data(buffer.data(), n);
            at += n;
        }
    }
    void add(const std::string& name, const std::string& text) {
        begin(name, text.size());
        data(text.data(), text.size());
    }
    void finish() {
        if (::archive_write_close(tar_) != ARCHIVE_OK) throw IoError("archive.tar", "broke off");
    }

  private:
    static la_ssize_t write(archive* /*tar*/, void* self, const void* bytes, size_t size) {
        auto* const stream = static_cast<TarStream*>(self);
        const bool sent = stream->sink_.write(static_cast<const char*>(bytes), size);
        return sent ? static_cast<la_ssize_t>(size) : -1;
    }
    void begin(const std::string& name, uint64_t size_bytes) {
        archive_entry* const entry = ::archive_entry_new();
        ::archive_entry_set_pathname(entry, name.c_str());
        ::archive_entry_set_size(entry, static_cast<la_int64_t>(size_bytes));
        ::archive_entry_set_filetype(entry, AE_IFREG);
        ::archive_entry_set_perm(entry, 0644);
        const int code = ::archive_write_header(tar_, entry);
        ::archive_entry_free(entry);
        if (code != ARCHIVE_OK) throw IoError("archive.tar", "broke off");
    }
    void data(const char* bytes, size_t size) {
        if (::archive_write_data(tar_, bytes, size) != static_cast<la_ssize_t>(size)) {
            throw IoError("archive.tar", "broke off");
        }
    }

    httplib::DataSink& sink_;
    archive* tar_;
};

/// Every file of a job, then the list of them. Throws DamagedFile: the archive then has no end, and
/// no reader takes it for whole.
void write_archive(JobStore& store, const JobSnapshot& job, httplib::DataSink& sink) {
    TarStream tar(sink);
    const std::string root = job.id + "/";
    Json manifest = Json::array();
    const auto list = [&](const std::string& name, const StoredFile& file) {
        manifest.push_back({{"name", name}, {"bytes", file.size_bytes}, {"sha256", file.sha256}});
    };
    for (uint64_t at = 0;; at += kUnitPage) {
        const std::vector<StoredUnit> units = store.published(job.sequence, at, kUnitPage);
        for (const StoredUnit& unit : units) {
            for (const StoredFile& file : unit.files) {
                const auto found =
                    store.open_unit_file(job.sequence, unit.name.probe, unit.name.state, file.name);
                const std::string name = unit.name.probe + "/" + unit.name.state + "/" + file.name;
                if (!found) throw IoError(name, "is gone");
                if (!found->content) throw DamagedFile(name, found->unit);
                tar.add(root + name, *found->content);
                list(name, file);
            }
        }
        if (units.size() < kUnitPage) break;
    }
    if (const auto report = store.open_job_file(job.sequence, kReportFile)) {
        if (!report->content) throw DamagedFile(kReportFile, report->unit);
        tar.add(root + kReportFile, *report->content);
        list(kReportFile, report->file);
    }
    tar.add(root + "manifest.json",
            dump_json({{"bake", job.id}, {"state", name_of(job.state)}, {"files", manifest}}, 1) +
                "\n");
    tar.finish();
}

}  // namespace

void Api::events(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = find_job(call);
    const auto place = std::make_shared<Place>(waiting_, parts_.max_waiting, "too-many-waiting");
    const auto id_of = [this](const JobSnapshot& seen) {
        return boot_id_ + "." + std::to_string(seen.version);
    };
    // What the client saw last: it is told of what it missed, in the state in which it is now.
    const auto last = std::make_shared<std::string>(call.request.get_header_value("Last-Event-ID"));
    // A client asks again with the last id that it has; a connection is not held for ever.
    const auto end = Clock::now() + parts_.events_time;
    call.response.headers.erase("Cache-Control");
    call.response.set_header("Cache-Control", "no-store");
    answer_stream(
        "text/event-stream",
        [this, id = job.id, place, id_of, last, end](size_t offset, httplib::DataSink& sink) {
            if (offset == 0) {
                const std::string hello = "retry: 1000\n\n";
                if (!sink.write(hello.data(), hello.size())) return false;
            }
            std::optional<JobSnapshot> now = parts_.jobs.find(id);
            if (now && id_of(*now) == *last && !is_terminal(now->state)) {
                const auto left =
                    std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
                now = parts_.jobs.wait_for_change(id, now->version,
                                                  std::min(parts_.comment_interval, left));
            }
            std::string text = ": still there\n\n";
            if (now && id_of(*now) != *last) {
                text = event(is_terminal(now->state) ? "end" : "status", id_of(*now),
                             write_job_status(*now));
                *last = id_of(*now);
            }
            if (!sink.write(text.data(), text.size())) return false;
            if (!now || is_terminal(now->state) || parts_.jobs.draining() || Clock::now() >= end) {
                sink.done();
            }
            return true;
        },
        call.request, call.response);
}

void Api::archive(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = find_job(call);
    if (!is_terminal(job.state)) {
        throw ProblemError({.status = 409,
                            .code = "not-finished",
                            .detail = "the bake is " + std::string(name_of(job.state)) +
                                      ": an archive is made when it has ended"});
    }
    const auto place = std::make_shared<Place>(waiting_, parts_.max_waiting, "too-many-waiting");
    const std::optional<OpenStored> report = parts_.store.open_job_file(job.sequence, kReportFile);
    if (report && !report->content) {
        throw ProblemError({.status = 410,
                            .code = "damaged",
                            .detail = "the report was damaged on the service's disk and cannot be "
                                      "made again; the other files are there one by one"});
    }
    call.response.set_header("Content-Disposition", "attachment; filename=\"" + job.id + ".tar\"");
    answer_stream(
        "application/x-tar",
        [this, job, place](size_t, httplib::DataSink& sink) {
            // The answer has begun: all that is left of errors is to break it off.
            try {
                write_archive(parts_.store, job, sink);
            } catch (const DamagedFile& file) {
                parts_.jobs.mend(job.id, file.unit());
                throw;  // into the log
            } catch (const IoError&) {
                return false;
            }
            sink.done();
            return true;
        },
        call.request, call.response);
}

}  // namespace probebake
