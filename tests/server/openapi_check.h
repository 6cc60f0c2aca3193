// Answers held against the service's own description of them (openapi.json): is this status
// described for this path and method, with these headers, and is the body what the schema says? And
// a request that was taken: is it one of the described ones? Of JSON Schema, what the document
// uses.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "http/openapi.h"
#include "http/router.h"
#include "io/json.h"

namespace probebake::test {

class OpenApiCheck {
  public:
    OpenApiCheck() : document_(Json::parse(openapi_text())) {
        for (const auto& [path, methods] : document_.at("paths").items()) {
            for (const auto& [method, operation] : methods.items()) {
                std::string upper = method;
                for (char& c : upper) c = static_cast<char>(std::toupper(c));
                router_.add(upper, path);
                operations_.push_back(&operation);
            }
        }
    }

    /// What is wrong with an answer, one line each; nothing is said of paths that are not there.
    std::vector<std::string> problems(const std::string& method, const std::string& target,
                                      int status, const std::string& type,
                                      const std::string& body) const {
        const Router::Match match = router_.find(method, target.substr(0, target.find('?')));
        std::vector<std::string> problems;
        const std::string where = method + " " + target + " " + std::to_string(status);
        if (!match.route) return problems;
        const Json& responses = operations_[*match.route]->at("responses");
        const std::string code = std::to_string(status);
        if (!responses.contains(code) && status < 400) return {where + " is not described"};
        const Json& response = resolve(responses.at(responses.contains(code) ? code : "default"));
        if (!response.contains("content")) {
            if (!body.empty()) problems.push_back(where + " has a body");
            return problems;
        }
        const std::string plain = type.substr(0, type.find(';'));
        if (!response["content"].contains(plain)) return {where + " is of type " + type};
        if (method != "HEAD" && plain.ends_with("json")) {
            check(response["content"][plain]["schema"], parse_json(body), where, problems);
        }
        return problems;
    }

    /// Headers of an answer that its description does not have; those of every answer are left out.
    std::vector<std::string> undescribed(const std::string& method, const std::string& target,
                                         int status, const std::set<std::string>& headers) const {
        static const std::set<std::string> kOfAll = {
            "Accept-Ranges",     "Cache-Control",          "Connection",
            "Content-Length",    "Content-Type",           "Keep-Alive",
            "Transfer-Encoding", "X-Content-Type-Options", "X-Request-Id"};
        const Router::Match match = router_.find(method, target.substr(0, target.find('?')));
        std::vector<std::string> problems;
        if (!match.route) return problems;
        const Json& responses = operations_[*match.route]->at("responses");
        const std::string code = std::to_string(status);
        const Json& response = resolve(responses.at(responses.contains(code) ? code : "default"));
        const std::string answer = method + " " + target + " " + code + ": header ";
        for (const std::string& header : headers) {
            if (kOfAll.contains(header)) continue;
            if (!response.contains("headers") || !response["headers"].contains(header)) {
                problems.push_back(answer + header + " is not described");
            }
        }
        return problems;
    }

    /// What is wrong with a value that should have this schema.
    std::vector<std::string> schema_problems(const std::string& name, const Json& value) const {
        std::vector<std::string> problems;
        check(schema(name), value, name, problems);
        return problems;
    }

    /// What is wrong with the body of a request to this path.
    std::vector<std::string> request_problems(const std::string& method, const std::string& target,
                                              const Json& body) const {
        const Router::Match match = router_.find(method, target.substr(0, target.find('?')));
        std::vector<std::string> problems;
        if (!match.route || !operations_[*match.route]->contains("requestBody")) return problems;
        check(operations_[*match.route]->at("requestBody")["content"]["application/json"]["schema"],
              body, method + " " + target, problems);
        return problems;
    }
    const Json& schema(const std::string& name) const {
        return document_.at("components").at("schemas").at(name);
    }
    const Json& resolve(const Json& schema) const {
        if (!schema.contains("$ref")) return schema;
        return document_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1)));
    }

    bool describes(const std::string& method, const std::string& pattern) const {
        std::string lower = method;
        for (char& c : lower) c = static_cast<char>(std::tolower(c));
        return document_["paths"].contains(pattern) && document_["paths"][pattern].contains(lower);
    }
    size_t operations() const { return operations_.size(); }

  private:
    static bool is(const Json& value, const std::string& type) {
        if (type == "integer") return value.is_number_integer();
        if (type == "number") return value.is_number();
        if (type == "null") return value.is_null();
        return value.type_name() == type;
    }
    static const std::regex& regex(const std::string& pattern) {
        static std::mutex mutex;
        static std::map<std::string, std::regex> known;
        const std::lock_guard lock(mutex);
        return known.try_emplace(pattern, pattern).first->second;
    }
    void check(const Json& given, const Json& value, const std::string& where,
               std::vector<std::string>& problems) const {
        const Json& schema = resolve(given);
        if (schema.contains("anyOf")) {
            std::vector<std::string> of_all;
            for (const Json& one : schema["anyOf"]) {
                std::vector<std::string> of_one;
                check(one, value, where, of_one);
                if (of_one.empty()) return;
                of_all.insert(of_all.end(), of_one.begin(), of_one.end());
            }
            problems.insert(problems.end(), of_all.begin(), of_all.end());
            return;
        }
        if (schema.contains("type")) {
            const Json types =
                schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
            bool any = false;
            for (const Json& type : types) any = any || is(value, type);
            if (!any) problems.push_back(where + ": is a " + value.type_name());
        }
        if (schema.contains("enum") && std::find(schema["enum"].begin(), schema["enum"].end(),
                                                 value) == schema["enum"].end()) {
            problems.push_back(where + ": is none of the values");
        }
        if (schema.contains("const") && schema["const"] != value) {
            problems.push_back(where + ": is another value");
        }
        if (schema.contains("minimum") && value.is_number() && value < schema["minimum"]) {
            problems.push_back(where + ": is too small");
        }
        if (schema.contains("exclusiveMinimum") && value.is_number() &&
            value <= schema["exclusiveMinimum"]) {
            problems.push_back(where + ": is too small");
        }
        if (schema.contains("maximum") && value.is_number() && value > schema["maximum"]) {
            problems.push_back(where + ": is too large");
        }
        if (schema.contains("pattern") && value.is_string() &&
            !std::regex_search(value.get<std::string>(), regex(schema["pattern"]))) {
            problems.push_back(where + ": is not of the form");
        }
        if (value.is_array() && (value.size() < schema.value("minItems", size_t{0}) ||
                                 value.size() > schema.value("maxItems", value.size()))) {
            problems.push_back(where + ": has another number of elements");
        }
        for (const Json& name : schema.value("required", Json::array())) {
            if (!value.contains(name)) problems.push_back(where + ": lacks " + name.dump());
        }
        if (schema.contains("items") && value.is_array()) {
            constexpr size_t kEnough = 100;  // the rest of a long list is like them
            for (size_t i = 0; i < std::min(value.size(), kEnough); ++i) {
                check(schema["items"], value[i], where + "/" + std::to_string(i), problems);
            }
        }
        if (!value.is_object()) return;
        const Json none = Json::object();
        const Json& properties = schema.contains("properties") ? schema["properties"] : none;
        for (const auto& [key, part] : value.items()) {
            if (properties.contains(key)) {
                check(properties[key], part, std::string(where).append("/").append(key), problems);
            } else if (schema.contains("additionalProperties") &&
                       schema["additionalProperties"] == false) {
                problems.push_back(std::string(where).append(": has an undescribed ").append(key));
            }
        }
    }

    const Json document_;
    Router router_;
    std::vector<const Json*> operations_;
};

/// Keeps an answer for tests/openapi/check_exchanges.py, where that asked for it.
inline void record_exchange(const Json& exchange) {
    const char* const path = std::getenv("PROBEBAKE_EXCHANGES");
    if (path == nullptr) return;
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    std::ofstream(path, std::ios::app) << dump_json(exchange) << '\n';
}

/// Fails the test that got this answer where the description says otherwise.
inline void expect_described(const std::string& method, const std::string& target, int status,
                             const std::string& type, const std::string& body,
                             const std::set<std::string>& headers) {
    const bool text = type.find("json") != std::string::npos;
    record_exchange({{"method", method},
                     {"target", target},
                     {"status", status},
                     {"type", type},
                     {"body", text           ? body
                              : body.empty() ? ""
                                             : "bytes"}});
    static const OpenApiCheck api;
    for (const std::string& problem : api.problems(method, target, status, type, body)) {
        ADD_FAILURE() << problem;
    }
    for (const std::string& problem : api.undescribed(method, target, status, headers)) {
        ADD_FAILURE() << problem;
    }
}

/// Fails the test whose request was taken although the description has no such one.
inline void expect_described_request(const std::string& method, const std::string& target,
                                     const std::string& body) {
    static const OpenApiCheck api;
    for (const std::string& problem : api.request_problems(method, target, parse_json(body))) {
        ADD_FAILURE() << problem;
    }
}

}  // namespace probebake::test
