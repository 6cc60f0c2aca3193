// What a job made, over HTTP: report, rows, files.
#include "http/api.h"
#include "http/query.h"
#include "io/io_error.h"

namespace probebake {
namespace {

constexpr uint64_t kMaxPage = 100;
constexpr uint64_t kDefaultPage = 50;
constexpr size_t kChunkBytes = size_t{64} << 10;

/// Streams an open file. The library's idea of offset and length is bounded by the file.
void answer_file(std::shared_ptr<const OpenFile> file, const char* type,
                 httplib::Response& response) {
    const uint64_t size_bytes = file->size_bytes();
    response.set_content_provider(
        size_bytes, type,
        [file = std::move(file), buffer = std::make_shared<std::vector<char>>(kChunkBytes)](
            size_t offset, size_t length, httplib::DataSink& sink) {
            try {
                const size_t n =
                    file->read_at(offset, std::span(*buffer).first(std::min(length, kChunkBytes)));
                return n > 0 && sink.write(buffer->data(), n);
            } catch (const IoError&) {
                return false;  // the answer has begun: all that is left is to break it off
            }
        });
}

/// If-None-Match (RFC 9110, 13.1.2) with weak comparison.
bool matches(const httplib::Request& request, const std::string& etag) {
    for (size_t i = 0; i < request.get_header_value_count("If-None-Match"); ++i) {
        const std::string tags = request.get_header_value("If-None-Match", i);
        // A strong tag of ours holds no comma and no quotation mark inside.
        if (tags == "*" || tags.find(etag) != std::string::npos) return true;
    }
    return false;
}

Json write_unit(const StoredUnit& unit) {
    Json json = {{"probe", unit.probe}, {"state", unit.state}, {"files", Json::array()}};
    for (const StoredFile& file : unit.files) {
        json["files"].push_back(
            {{"name", file.name}, {"bytes", file.size_bytes}, {"sha256", file.sha256}});
    }
    return json;
}

[[noreturn]] void refuse_token() {
    QueryReader::refuse("page_token", "expected what a page before gave");
}

/// Where a page of rows begins: "u" and a count of published units, or "r" and a byte of the rows.
struct RowToken {
    bool final_rows = false;
    uint64_t at = 0;
};

RowToken read_token(const std::string& text) {
    const std::optional<uint64_t> at =
        read_digits(std::string_view(text).substr(text.empty() ? 0 : 1));
    if (!at || (text[0] != 'u' && text[0] != 'r')) refuse_token();
    return {text[0] == 'r', *at};
}

}  // namespace

void Api::report(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = find_job(call);
    if (job.state != JobState::kSucceeded) {
        const std::string state(name_of(job.state));
        throw ProblemError(
            {.status = 409,
             .code = is_terminal(job.state) ? "no-report" : "not-finished",
             .detail = "the bake is " + state +
                       (is_terminal(job.state) ? ": it has no report"
                                               : ": its report is made when it has SUCCEEDED")});
    }
    std::shared_ptr<const OpenFile> file = parts_.store.open_report(job.id);
    if (!file) find_job(call);  // forgotten in between
    if (!file) throw IoError("report.json", "is missing");
    answer_file(std::move(file), "application/json", call.response);
}

void Api::rows(const Call& call) {
    QueryReader query(call.request);
    const uint64_t count = query.integer("page_size", 1, kMaxPage, kDefaultPage);
    const std::optional<std::string> text = query.text("page_token");
    query.refuse_unknown();
    const JobSnapshot job = find_job(call);
    const RowToken token =
        text ? read_token(*text) : RowToken{.final_rows = job.state == JobState::kSucceeded};

    std::string body;
    std::string next;
    if (token.final_rows) {
        const std::optional<RowPage> page = parts_.store.rows(job.id, token.at, count);
        if (!page) refuse_token();
        for (const std::string& row : page->rows) body += (body.empty() ? "" : ",\n") + row;
        if (page->next) next = "r" + std::to_string(*page->next);
    } else {
        const std::vector<StoredUnit> units = parts_.store.units(job.id, token.at, count);
        for (const StoredUnit& unit : units) {
            body += (body.empty() ? "" : ",\n") + dump_json(write_unit(unit));
        }
        const bool more = token.at + units.size() < parts_.store.unit_count(job.id);
        if (more) next = "u" + std::to_string(token.at + units.size());
    }
    // The rows are JSON texts already: a page of them is not parsed to be written again.
    call.response.set_content(
        std::string("{\"final\":") + (token.final_rows ? "true" : "false") + ",\"rows\":[" + body +
            "]" + (next.empty() ? "" : ",\"next_page_token\":\"" + next + "\"") + "}\n",
        "application/json");
}

void Api::file(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = find_job(call);
    std::optional<OpenArtifact> found = parts_.store.open(
        job.id, call.params.at("probe"), call.params.at("state"), call.params.at("file"));
    if (!found) {
        throw ProblemError({.status = 404,
                            .code = is_terminal(job.state) ? "unknown-file" : "not-baked-yet",
                            .detail = is_terminal(job.state)
                                          ? "the bake has no such file"
                                          : "the bake has no such file, or not yet"});
    }
    const std::string etag = "\"" + found->file.sha256 + "\"";
    call.response.set_header("ETag", etag);
    call.response.headers.erase("Cache-Control");
    call.response.set_header("Cache-Control", "private, no-cache");  // check with the tag, then use
    if (matches(call.request, etag)) {
        call.response.status = 304;
        return;
    }
    const bool json = found->file.name.ends_with(".json");
    answer_file(std::move(found->content), json ? "application/json" : "image/x-exr",
                call.response);
}

}  // namespace probebake
