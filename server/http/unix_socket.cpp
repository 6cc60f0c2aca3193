#include "http/unix_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "store/open_file.h"

namespace probebake {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
    throw std::runtime_error("cannot listen on " + path.string() + ": " + why);
}

}  // namespace

int listen_on_unix_socket(const std::filesystem::path& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string text = path.string();
    if (text.size() >= sizeof(address.sun_path)) refuse(path, "the path is too long");
    std::memcpy(address.sun_path, text.c_str(), text.size() + 1);
    const auto* const to = reinterpret_cast<const sockaddr*>(&address);

    const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (::connect(probe.get(), to, sizeof(address)) == 0) refuse(path, "another service does");
    if (errno == ECONNREFUSED) ::unlink(path.c_str());  // nobody listens any more

    const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const mode_t before = ::umask(S_IXUSR | S_IXGRP | S_IRWXO);
    const bool bound = ::bind(socket, to, sizeof(address)) == 0;
    const int error = errno;
    ::umask(before);
    if (!bound || ::listen(socket, kBacklog) != 0) {
        ::close(socket);
        refuse(path, std::strerror(bound ? errno : error));
    }
    return socket;
}

}  // namespace probebake
