#include "http/access.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "io/file.h"
#include "io/sha256.h"
#include "store/job_state.h"

namespace probebake {
namespace {

constexpr std::array<std::string_view, 4> kScopeNames = {"submit", "read", "metrics", "admin"};
constexpr size_t kTimeDigits = 19;  // 2027-01-31T00:00:00

bool is_digest(const std::string& text) {
    return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// A time of the calendar in the one form that can be compared as text.
bool is_time(const std::string& text) {
    constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
    if (text.size() != kForm.size()) return false;
    for (size_t i = 0; i < kForm.size(); ++i) {
        const bool digit = text[i] >= '0' && text[i] <= '9';
        if (kForm[i] == 'd' ? !digit : text[i] != kForm[i]) return false;
    }
    const auto number = [&](size_t at, size_t digits) {
        return std::stoi(text.substr(at, digits));
    };
    const std::chrono::year_month_day day{std::chrono::year(number(0, 4)),
                                          std::chrono::month(static_cast<unsigned>(number(5, 2))),
                                          std::chrono::day(static_cast<unsigned>(number(8, 2)))};
    return day.ok() && number(11, 2) < 24 && number(14, 2) < 60 && number(17, 2) < 60;
}

/// "Bearer " in whatever case.
bool is_bearer(std::string_view authorization) {
    constexpr std::string_view kScheme = "bearer ";
    return authorization.size() >= kScheme.size() &&
           std::equal(kScheme.begin(), kScheme.end(), authorization.begin(), [](char ours, char c) {
               return ours == (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
           });
}

}  // namespace

Tokens::Tokens(const std::filesystem::path& file) : required_(true) {
    const std::vector<std::byte> bytes = read_file(file, uint64_t{16} << 20);
    const Json json = parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    JsonIssues issues;
    ObjectReader reader(json, "", issues);
    for (const ObjectReader::Element& element : reader.array("tokens", 100'000)) {
        ObjectReader entry(*element.value, element.pointer, issues);
        Entry token;
        token.identity.tenant = entry.name("tenant", std::nullopt);
        token.sha256 = entry.string("sha256", 64, std::nullopt);
        if (!is_digest(token.sha256)) {
            issues.malformed(entry.pointer_to("sha256"), "expected 64 hexadecimal digits");
        }
        token.expires_at = entry.string("expires_at", 32, std::string());
        if (!token.expires_at.empty() && !is_time(token.expires_at)) {
            issues.malformed(entry.pointer_to("expires_at"),
                             "expected a time like 2027-01-31T00:00:00Z");
        }
        for (const ObjectReader::Element& scope : entry.array("scopes", kScopeNames.size())) {
            size_t i = 0;
            while (i < kScopeNames.size() && *scope.value != kScopeNames[i]) ++i;
            if (i == kScopeNames.size()) {
                issues.malformed(scope.pointer, "expected submit, read, metrics or admin");
            } else {
                token.identity.scopes |= 1U << i;
            }
        }
        entry.refuse_unknown();
        entries_.push_back(std::move(token));
    }
    reader.refuse_unknown();
    issues.throw_if_any();
}

std::optional<Identity> Tokens::find(std::string_view authorization, std::string_view now) const {
    if (!is_bearer(authorization)) return std::nullopt;
    const std::string_view token = authorization.substr(authorization.find(' ') + 1);
    const std::string digest = sha256_hex(std::as_bytes(std::span(token)));
    std::optional<Identity> found;
    for (const Entry& entry : entries_) {
        const bool same = ::CRYPTO_memcmp(entry.sha256.data(), digest.data(), digest.size()) == 0;
        const bool valid = entry.expires_at.empty() ||
                           now.substr(0, kTimeDigits) < entry.expires_at.substr(0, kTimeDigits);
        if (same && valid) found = entry.identity;
    }
    return found;
}

std::string new_token() { return "pb_" + new_job_id().substr(2) + new_job_id().substr(2); }

Json write_token_entry(const std::string& token, const std::string& tenant,
                       const std::vector<std::string>& scopes, const std::string& expires_at) {
    JsonIssues issues;
    if (!is_name(tenant)) issues.malformed("/tenant", "expected a name");
    for (const std::string& scope : scopes) {
        if (std::find(kScopeNames.begin(), kScopeNames.end(), scope) == kScopeNames.end()) {
            issues.malformed("/scopes", "expected submit, read, metrics or admin");
        }
    }
    if (!expires_at.empty() && !is_time(expires_at)) {
        issues.malformed("/expires_at", "expected a time like 2027-01-31T00:00:00Z");
    }
    issues.throw_if_any();
    Json entry = {{"tenant", tenant},
                  {"sha256", sha256_hex(std::as_bytes(std::span(token)))},
                  {"scopes", scopes}};
    if (!expires_at.empty()) entry["expires_at"] = expires_at;
    return entry;
}

}  // namespace probebake
