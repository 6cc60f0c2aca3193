#include "http/router.h"

#include <algorithm>

namespace probebake {
namespace {

std::vector<std::string> split(std::string_view path) {
    std::vector<std::string> segments;
    size_t begin = 0;
    for (;;) {
        const size_t end = path.find('/', begin);
        segments.emplace_back(path.substr(begin, end - begin));
        if (end == std::string_view::npos) return segments;
        begin = end + 1;
    }
}

/// Whether a segment fits its pattern; the parameter, if it is one, goes into `params`.
bool fits(const std::string& pattern, const std::string& segment, PathParams& params) {
    if (pattern.empty() || pattern.front() != '{') return segment == pattern;
    const size_t end = pattern.find('}');
    const std::string action = pattern.substr(end + 1);
    if (segment.size() <= action.size()) return false;
    const size_t length = segment.size() - action.size();
    const std::string value = segment.substr(0, length);
    if (segment.substr(length) != action || value.find(':') != std::string::npos) return false;
    params[pattern.substr(1, end - 1)] = value;
    return true;
}

}  // namespace

void Router::add(std::string method, std::string_view pattern) {
    routes_.push_back({std::move(method), split(pattern)});
}

Router::Match Router::find(std::string_view method, std::string_view path) const {
    const std::string_view wanted = method == "HEAD" ? "GET" : method;
    const std::vector<std::string> segments = split(path);
    Match match;
    for (size_t r = 0; r < routes_.size(); ++r) {
        const Route& route = routes_[r];
        if (route.segments.size() != segments.size()) continue;
        PathParams params;
        bool same = true;
        for (size_t i = 0; same && i < segments.size(); ++i) {
            same = fits(route.segments[i], segments[i], params);
        }
        if (!same) continue;
        match.allow += (match.allow.empty() ? "" : ", ") + route.method;
        if (route.method == "GET") match.allow += ", HEAD";
        if (route.method != wanted || match.route) continue;
        match.route = r;
        match.params = std::move(params);
    }
    return match;
}

}  // namespace probebake
