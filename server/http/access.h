// Who may do what: bearer tokens, each of a tenant and for some scopes.
//
// A file of tokens holds their SHA-256 only:
//
//   {"tokens": [{"tenant": "lab", "sha256": "…", "scopes": ["submit", "read"],
//                "expires_at": "2027-01-31T00:00:00Z"}]}
//
// `submit` takes jobs, cancels and deletes the tenant's own, `read` sees them, `metrics` sees
// /metrics, `admin` does all of that with everybody's. `probebake token` makes an entry.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/json.h"

namespace probebake {

enum class Scope : unsigned { kOpen = 0, kSubmit = 1, kRead = 2, kMetrics = 4, kAdmin = 8 };

struct Identity {
    std::string tenant;
    unsigned scopes = 0;

    bool may(Scope scope) const {
        const auto wanted = static_cast<unsigned>(scope);
        return (scopes & static_cast<unsigned>(Scope::kAdmin)) != 0 || (scopes & wanted) == wanted;
    }
    bool is_admin() const { return (scopes & static_cast<unsigned>(Scope::kAdmin)) != 0; }
    /// Jobs of other tenants are as if they were not there.
    bool sees(const std::string& of_tenant) const { return is_admin() || tenant == of_tenant; }
};

class Tokens {
  public:
    /// Without tokens: whoever reaches the service may do everything.
    Tokens() = default;
    /// Throws IoError and SpecError.
    explicit Tokens(const std::filesystem::path& file);

    bool required() const { return required_; }
    /// The identity behind "Bearer TOKEN"; none where there is none, or no longer. `now` is a time
    /// in RFC 3339. The comparison takes as long for any token.
    std::optional<Identity> find(std::string_view authorization, std::string_view now) const;

  private:
    struct Entry {
        std::string sha256;
        std::string expires_at;  // empty: never
        Identity identity;
    };
    std::vector<Entry> entries_;
    bool required_ = false;
};

/// 256 random bits of the kernel.
std::string new_token();
/// An entry for a file of tokens. Throws SpecError for an unknown scope or a bad tenant.
Json write_token_entry(const std::string& token, const std::string& tenant,
                       const std::vector<std::string>& scopes, const std::string& expires_at);

}  // namespace probebake
