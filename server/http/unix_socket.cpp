#include "http/unix_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

#include "store/open_file.h"

namespace probebake {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
    throw std::runtime_error("cannot listen on " + path.string() + ": " + why);
}

sockaddr_un address_of(const std::filesystem::path& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string text = path.string();
    if (text.size() >= sizeof(address.sun_path)) refuse(path, "the path is too long");
    std::memcpy(address.sun_path, text.c_str(), text.size() + 1);
    return address;
}

bool is_listened_on(const std::filesystem::path& path) {
    const sockaddr_un address = address_of(path);
    const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    return ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) ==
           0;
}

}  // namespace

int listen_on_unix_socket(const std::filesystem::path& path) {
    if (is_listened_on(path)) refuse(path, "another service does");
    std::error_code error;
    const auto there = std::filesystem::symlink_status(path, error);
    if (std::filesystem::exists(there) && !std::filesystem::is_socket(there)) {
        refuse(path, "there is a file");
    }
    // Under another name until it listens: who finds it can connect.
    const std::filesystem::path early = path.string() + ".new";
    const sockaddr_un address = address_of(early);
    ::unlink(early.c_str());
    const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const mode_t before = ::umask(S_IXUSR | S_IXGRP | S_IRWXO);
    const bool bound =
        ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
    int problem = errno;
    ::umask(before);
    if (bound && ::listen(socket, kBacklog) == 0 && ::rename(early.c_str(), path.c_str()) == 0) {
        return socket;
    }
    if (bound) problem = errno;
    ::close(socket);
    ::unlink(early.c_str());
    refuse(path, std::strerror(problem));
}

}  // namespace probebake
