// Running other people's programs in tests, which skip where one is not installed.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace probebake::test {

struct ToolOutput {
    int status = -1;
    std::string text;  // standard output and error
};

inline ToolOutput run_tool(const std::string& command) {
    ToolOutput output;
    FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
    std::array<char, 4096> buffer{};
    while (const size_t count = fread(buffer.data(), 1, buffer.size(), pipe)) {
        output.text.append(buffer.data(), count);
    }
    const int status = pclose(pipe);
    output.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return output;
}

inline bool has_tool(const std::string& name) { return run_tool("command -v " + name).status == 0; }

/// The first number behind a text, as the tool printed it.
inline double number_after(const std::string& output, const std::string& text) {
    const size_t at = output.find(text);
    if (at == std::string::npos) throw std::runtime_error("no \"" + text + "\" in: " + output);
    return std::stod(output.substr(at + text.size()));
}

/// A new folder, removed with everything in it at the end.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string path = (std::filesystem::temp_directory_path() / "probebake-XXXXXX").string();
        if (mkdtemp(path.data()) == nullptr) throw std::runtime_error("cannot make " + path);
        path_ = path;
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

}  // namespace probebake::test
