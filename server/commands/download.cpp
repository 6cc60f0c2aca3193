#include "commands/download.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "io/file.h"
#include "io/sha256.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

struct Wanted {
    std::string name;
    uint64_t bytes = 0;
    std::string sha256;
};

/// A row's text that becomes part of a path: a service must not lead us out of our folder.
std::string safe_name(const Json& row, const char* key) {
    auto name = row.at(key).get<std::string>();
    if (!is_name(name)) {
        throw ServiceError(0, "the service sent a row whose " + std::string(key) +
                                  " is no name: " + dump_json(name));
    }
    return name;
}

bool already_there(const fs::path& path, const Wanted& wanted) {
    std::error_code error;
    if (fs::file_size(path, error) != wanted.bytes || error) return false;
    Sha256 sha;
    std::ifstream file(path, std::ios::binary);
    std::vector<char> buffer(1 << 16);
    while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) ||
           file.gcount() > 0) {
        sha.update(std::string_view(buffer.data(), static_cast<size_t>(file.gcount())));
    }
    return sha.hex() == wanted.sha256;
}

/// Fetches into a file beside `path`, checks, then renames.
void fetch(ServiceClient& service, const std::string& from, const fs::path& path,
           const Wanted& wanted) {
    const fs::path part = path.string() + ".part";
    Sha256 sha;
    uint64_t bytes = 0;
    {
        std::ofstream file(part, std::ios::binary | std::ios::trunc);
        service.download(from, [&](std::string_view piece) {
            bytes += piece.size();
            sha.update(piece);
            file.write(piece.data(), static_cast<std::streamsize>(piece.size()));
        });
        file.close();
        if (!file)
            throw IoError(part.string(), std::string("cannot be written: ") + std::strerror(errno));
    }
    const std::string sha256 = sha.hex();
    if (bytes != wanted.bytes || sha256 != wanted.sha256) {
        fs::remove(part);
        throw IoError(path.string(), "came with " + std::to_string(bytes) + " bytes and SHA-256 " +
                                         sha256 + ", expected " + std::to_string(wanted.bytes) +
                                         " and " + wanted.sha256);
    }
    fs::rename(part, path);
}

}  // namespace

Download download_bake(ServiceClient& service, const std::string& id, const fs::path& out,
                       const std::function<void(uint64_t)>& on_file) {
    const std::string bake = "/v1/bakes/" + id;
    Download done;
    std::string lines;
    fs::create_directories(out);
    std::string page = bake + "/probes?page_size=100";
    for (bool more = true; more;) {
        const Json answer = service.get(page);
        for (Json row : answer.at("rows")) {
            const char* const of = row.contains("grid") ? "grid" : "probe";
            const fs::path place = fs::path(safe_name(row, of)) / safe_name(row, "state");
            fs::create_directories(out / place);
            for (const Json& file : row.at("files")) {
                const Wanted wanted{safe_name(file, "name"), file.at("bytes").get<uint64_t>(),
                                    file.at("sha256").get<std::string>()};
                const fs::path path = out / place / wanted.name;
                if (already_there(path, wanted)) {
                    ++done.kept;
                } else {
                    fetch(service, bake + "/probes/" + (place / wanted.name).generic_string(), path,
                          wanted);
                }
                done.bytes += wanted.bytes;
                on_file(++done.files);
            }
            lines += dump_json(row) + "\n";
            row.erase("faces");
            done.rows.push_back(std::move(row));
        }
        more = answer.contains("next_page_token");
        if (more) {
            page = bake + "/probes?page_size=100&page_token=" +
                   answer["next_page_token"].get<std::string>();
        }
    }
    write_file_atomically(out / "probes.jsonl", lines);
    try {
        done.report = service.get(bake + "/report");
        write_file_atomically(out / "report.json", dump_json(*done.report, 2) + "\n");
    } catch (const ServiceError& error) {
        if (error.status() != 409) throw;  // it has none, or not yet
    }
    return done;
}

}  // namespace probebake
