// The description of the API (openapi.json, OpenAPI 3.1), as the service serves it. It is compiled
// in, so that the binary needs no file of its own; tests hold it against the routes and the
// answers.
#pragma once

#include <string_view>

namespace probebake {

std::string_view openapi_text();

}  // namespace probebake
