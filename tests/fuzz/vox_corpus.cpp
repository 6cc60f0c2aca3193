// vox_corpus DIRECTORY: writes the seeds of vox_import_fuzz.
#include <cstdio>
#include <exception>

#include "io/file.h"
#include "scene/vox_seeds.h"

int main(int argument_count, char** arguments) {
    if (argument_count != 2) {
        std::fputs("usage: vox_corpus DIRECTORY\n", stderr);
        return 2;
    }
    try {
        for (const auto& [name, bytes] : probebake::test::vox_seeds()) {
            probebake::write_file_atomically(std::filesystem::path(arguments[1]) / name, bytes);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
