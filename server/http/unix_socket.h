// A listening unix socket: reachable for processes of this machine with rights to its path alone,
// as the proxy in front of the service (configs/nginx.conf).
#pragma once

#include <filesystem>

namespace probebake {

/// Connections that may wait to be accepted.
inline constexpr int kBacklog = 1024;

/// Owner and group may connect. What a service that is gone left behind is replaced. Throws
/// std::runtime_error where another listens there or the path cannot be had.
int listen_on_unix_socket(const std::filesystem::path& path);

}  // namespace probebake
