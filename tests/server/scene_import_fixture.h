// Scene files of other programs, in a folder of a test's own, and processes that import them.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <random>

#include "engine/render_pool.h"
#include "engine/scene_import.h"
#include "io/file.h"
#include "scene/vox_seeds.h"
#include "support/temp_folder.h"

namespace probebake::test {

class SceneImportTest : public testing::Test {
  protected:
    std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }

    SceneFile scene(const Bytes& vox) const {
        write_file_atomically(path("model.vox"), vox);
        write_text(path("model.json"),
                   R"({"type": "vox", "file": "model.vox", "voxel_size_m": 0.5})");
        return read_scene_file(path("model.json"));
    }
    /// A program in the importer's place.
    ImportProcess process(const std::string& script = {}) const {
        ImportProcess process{.program = PROBEBAKE_BINARY, .scratch = path("scratch")};
        if (script.empty()) return process;
        process.program = path("program");
        write_text(process.program, "#!/bin/sh\n" + script + "\n");
        ::chmod(process.program.c_str(), 0755);
        return process;
    }
    std::string refusal(const SceneFile& file, const ImportProcess& with) {
        try {
            import_in_process(with, file, path("cache"), cancel_);
        } catch (const IoError& error) {
            return error.what();
        }
        return "";
    }
    /// The file is cut off at some places and has some bytes changed: what comes of it is a scene
    /// or a reason, never the end of this process, and no child is left.
    void expect_damage_is_told(const std::string& json, const std::string& file,
                               const std::string& whole) {
        std::mt19937_64 random(3);
        const auto outcome = [&](const std::string& bytes) {
            write_text(path(file), bytes);
            return refusal(read_scene_file(path(json)), process());
        };
        EXPECT_EQ(outcome(whole), "");
        int refused = 0;
        for (int i = 0; i < 24; ++i) {
            std::string bytes = whole;
            if (i % 3 == 0) {
                bytes.resize(random() % bytes.size());
            } else {
                for (int k = 0; k < i; ++k) {
                    bytes[random() % bytes.size()] = static_cast<char>(random());
                }
            }
            const std::string reason = outcome(bytes);
            refused += reason.empty() ? 0 : 1;
            EXPECT_EQ(reason.find('\n'), std::string::npos) << reason;
        }
        EXPECT_GE(refused, 8);
        EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
    }

    TempFolder folder_;
    RenderPool pool_{2};
    CancelToken cancel_;
};

}  // namespace probebake::test
