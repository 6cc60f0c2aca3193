// The client's side of the API: one request at a time to a running service.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "io/json.h"

namespace probebake {

/// The service refused, or could not be reached. what() is for people: the problem's detail, then
/// one line per error with its pointer.
class ServiceError : public std::runtime_error {
  public:
    ServiceError(int status, const std::string& text) : std::runtime_error(text), status_(status) {}
    /// 0 where no answer came.
    int status() const { return status_; }

  private:
    int status_;
};

class ServiceClient {
  public:
    /// http://HOST:PORT
    explicit ServiceClient(const std::string& url);
    ~ServiceClient();

    /// The documents of 2xx answers. Throws ServiceError.
    Json get(const std::string& path);
    Json post(const std::string& path, const std::string& body = {});
    /// The same as `get`, in pieces as they come.
    void download(const std::string& path, const std::function<void(std::string_view)>& sink);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace probebake
