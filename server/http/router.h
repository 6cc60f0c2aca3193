// Router: which handler a method and path belong to.
//
// A pattern is a path whose segments are words or parameters: "/v1/bakes/{id}/report". A parameter
// stands for one non-empty segment without a colon, and may be followed by an action:
// "/v1/bakes/{id}:cancel".
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace probebake {

using PathParams = std::map<std::string, std::string, std::less<>>;

class Router {
  public:
    struct Match {
        std::optional<size_t> route;  // in the order of add()
        PathParams params;
        std::string allow;  // methods of the path; empty: there is no such path
    };

    void add(std::string method, std::string_view pattern);
    /// HEAD is answered by the handler of GET.
    Match find(std::string_view method, std::string_view path) const;

  private:
    struct Route {
        std::string method;
        std::vector<std::string> segments;
    };
    std::vector<Route> routes_;
};

}  // namespace probebake
