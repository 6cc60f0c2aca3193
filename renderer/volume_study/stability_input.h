// What the cases of input share: texts and documents with one number after the other turned into
// what is none, and how many of them were refused.
#pragma once

#include <string>

#include "io/io_error.h"
#include "io/json.h"
#include "io/spec_error.h"
#include "volume_study/stability.h"

namespace probebake::volume_study {

struct Refusals {
    int tried = 0;
    int refused = 0;

    template <class Call>
    void expect_refusal(Call call) {
        ++tried;
        try {
            call();
        } catch (const SpecError&) {
            ++refused;
        } catch (const IoError&) {
            ++refused;
        }
    }
    Refusals& operator+=(const Refusals& o) {
        tried += o.tried;
        refused += o.refused;
        return *this;
    }
};

inline StabilityCase refused_numbers(const std::string& what, const Refusals& got) {
    return at_least("NaN anywhere in the input",
                    what + ": refused, of " + std::to_string(got.tried), got.refused, got.tried);
}

/// Calls read(text) with every number of a JSON document turned into what is none.
template <class Read>
Refusals with_every_number(const std::string& text, Read read) {
    Refusals out;
    const Json flat = parse_json(text).flatten();
    for (const auto& [pointer, value] : flat.items()) {
        if (!value.is_number()) continue;
        for (const char* bad : {"NaN", "-NaN", "Infinity", "1e999", "-1e999"}) {
            Json changed = flat;
            changed[pointer] = "<here>";
            std::string broken = dump_json(changed.unflatten());
            const std::string mark = "\"<here>\"";
            broken.replace(broken.find(mark), mark.size(), bad);
            out.expect_refusal([&] { read(broken); });
        }
    }
    return out;
}

/// The same of a text of words: its numbers are the words that begin with a digit, a sign or a
/// point.
template <class Read>
Refusals with_every_word(const std::string& text, Read read) {
    Refusals out;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find_first_of(" \n", begin), text.size());
        if (std::string("+-.0123456789").find(text[begin]) != std::string::npos) {
            for (const char* bad : {"nan", "-nan", "inf", "-inf", "1e999", "-1e999"}) {
                std::string broken = text;
                broken.replace(begin, end - begin, bad);
                out.expect_refusal([&] { read(broken); });
            }
        }
        begin = text.find_first_not_of(" \n", end);
        if (begin == std::string::npos) break;
    }
    return out;
}

/// Of meshes and of heights in metres.
std::vector<StabilityCase> mesh_input_cases();

}  // namespace probebake::volume_study
