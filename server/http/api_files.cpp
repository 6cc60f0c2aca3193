// What a job made, over HTTP: report, rows, files.
#include "bake/report_page.h"
#include "http/api.h"
#include "http/file_answer.h"
#include "http/page_token.h"
#include "http/query.h"
#include "io/io_error.h"

namespace probebake {
namespace {

constexpr uint64_t kMaxPage = 100;
constexpr uint64_t kDefaultPage = 50;

Json write_unit(const StoredUnit& unit) {
    Json json = {{unit.is_grid ? "grid" : "probe", unit.name.probe},
                 {"state", unit.name.state},
                 {"files", Json::array()}};
    for (const StoredFile& file : unit.files) {
        json["files"].push_back(
            {{"name", file.name}, {"bytes", file.size_bytes}, {"sha256", file.sha256}});
    }
    return json;
}

/// A report of ours: as many values as 65,536 probes make.
Json read_json(const OpenFile& file) {
    std::string text(file.size_bytes(), '\0');
    uint64_t done = 0;
    while (done < text.size()) {
        const size_t n = file.read_at(done, std::span(text).subspan(done));
        if (n == 0) throw IoError("report.json", "ends early");
        done += n;
    }
    return parse_json(text, {.max_values = 10'000'000});
}

[[noreturn]] void refuse_damaged() {
    throw ProblemError({.status = 410,
                        .code = "damaged",
                        .detail = "the file was damaged on the service's disk and cannot be made "
                                  "again"});
}

[[noreturn]] void refuse_token() {
    QueryReader::refuse("page_token", "expected what a page before gave");
}

}  // namespace

void Api::report(const Call& call) {
    QueryReader query(call.request);
    const std::string format = query.text("format").value_or("json");
    query.refuse_unknown();
    if (format != "json" && format != "html") {
        QueryReader::refuse("format", "expected json or html");
    }
    const JobSnapshot job = find_job(call);
    const std::string is = "the bake is " + std::string(name_of(job.state));
    if (!is_terminal(job.state)) {
        throw ProblemError({.status = 409,
                            .code = "not-finished",
                            .detail = is + ": its report is made when all is done"});
    }
    std::optional<OpenStored> file = parts_.store.open_job_file(job.sequence, kReportFile);
    if (!file) {
        find_job(call);  // forgotten in between
        throw ProblemError(
            {.status = 409, .code = "no-report", .detail = is + ": it has no report"});
    }
    if (!file->content) refuse_damaged();
    if (format == "html") {
        call.response.set_header("Content-Security-Policy",
                                 "default-src 'none'; style-src 'unsafe-inline'");
        call.response.set_content(report_page(read_json(*file->content)),
                                  "text/html; charset=utf-8");
        return;
    }
    answer_file(std::move(file->content), "application/json", call.response);
}

void Api::rows(const Call& call) {
    QueryReader query(call.request);
    const uint64_t count = query.integer("page_size", 1, kMaxPage, kDefaultPage);
    const std::optional<std::string> text = query.text("page_token");
    query.refuse_unknown();
    const JobSnapshot job = find_job(call);
    const bool ended = is_terminal(job.state);
    std::optional<OpenStored> verdicts;
    if (ended) verdicts = parts_.store.open_unchecked(job.sequence, kRowFile);
    const std::optional<RowToken> given =
        text ? read_row_token(*text) : RowToken{.final_rows = verdicts.has_value()};
    if (!given) refuse_token();
    const RowToken token = *given;

    std::string body;
    std::string next;
    if (token.final_rows) {
        if (!verdicts) find_job(call);  // forgotten in between
        if (!verdicts) refuse_token();
        if (!verdicts->content) refuse_damaged();
        std::optional<RowPage> page;
        try {
            page = read_rows(*verdicts->content, token.at, count);
        } catch (const IoError&) {
            refuse_damaged();
        }
        if (!page) refuse_token();
        for (const std::string& row : page->rows) body += (body.empty() ? "" : ",\n") + row;
        if (page->next) next = write_row_token({true, *page->next});
    } else {
        std::vector<StoredUnit> units = parts_.store.published(job.sequence, token.at, count + 1);
        const bool more = units.size() > count;
        if (more) units.pop_back();
        for (const StoredUnit& unit : units) {
            body += (body.empty() ? "" : ",\n") + dump_json(write_unit(unit));
        }
        if (more) next = write_row_token({false, token.at + units.size()});
        if (ended) find_job(call);  // forgotten in between
    }
    // Of a job that ended without verdicts nothing more will come.
    const bool is_final = token.final_rows || (ended && !verdicts);
    // The rows are JSON texts already: a page of them is not parsed to be written again.
    call.response.set_content(
        std::string("{\"final\":") + (is_final ? "true" : "false") + ",\"rows\":[" + body + "]" +
            (next.empty() ? "" : ",\"next_page_token\":\"" + next + "\"") + "}\n",
        "application/json");
}

void Api::file(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = find_job(call);
    std::optional<OpenStored> found = parts_.store.open_unit_file(
        job.sequence, call.params.at("probe"), call.params.at("state"), call.params.at("file"));
    if (!found) {
        throw ProblemError({.status = 404,
                            .code = is_terminal(job.state) ? "unknown-file" : "not-baked-yet",
                            .detail = is_terminal(job.state)
                                          ? "the bake has no such file"
                                          : "the bake has no such file, or not yet"});
    }
    if (!found->content) {
        if (parts_.jobs.mend(job.id, found->unit) == JobManager::Mend::kImpossible) {
            refuse_damaged();
        }
        throw ProblemError({.status = 503,
                            .code = "being-mended",
                            .detail = "the file was damaged on the service's disk; it is baked "
                                      "again",
                            .retry_after_seconds = 2});
    }
    const bool json = found->file.name.ends_with(".json");
    answer_digested(std::move(found->content), found->file.sha256,
                    json ? "application/json" : "image/x-exr", call.request, call.response);
}

}  // namespace probebake
