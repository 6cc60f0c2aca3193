// What a disk may hold after the power was cut, given what a program did to its files until then.
//
// A pessimistic reading of POSIX: of a file, what was there at its last fsync is there, and of what
// was written since any 512-byte sectors, in any order; of a folder's names, those of its last
// fsync, and of the changes since either the first few or any; a rename happens as a whole, with
// the folder that it leads to.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "disk_log.h"
#include "promises.h"

namespace probebake::test {

class DiskModel {
  public:
    explicit DiskModel(std::string root) : root_(std::move(root)) {}

    void apply(const DiskOp& op) {
        switch (op.kind) {
            case DiskOp::kAck:
                for (const std::string& line : lines_of(op.data)) promises_.add(line);
                break;
            case DiskOp::kCreate:
                files_.emplace_back();
                live_[op.path] = files_.size() - 1;
                change({folder_of(op.path), "", op.path, files_.size() - 1});
                break;
            case DiskOp::kWrite:
            case DiskOp::kTruncate:
                if (live_.count(op.path) > 0) files_[live_[op.path]].pending.push_back(op);
                break;
            case DiskOp::kRename:
                live_[op.to] = live_.at(op.path);
                change({folder_of(op.to), op.path, op.to, live_.at(op.path)});
                live_.erase(op.path);
                break;
            case DiskOp::kUnlink:
                live_.erase(op.path);
                change({folder_of(op.path), op.path, "", 0});
                break;
            case DiskOp::kMakeFolder:
                folders_.push_back(op.path);
                break;
            case DiskOp::kSync:
                sync(op.path);
                break;
        }
    }

    const Promises& promises() const { return promises_; }
    bool is_file(const std::string& path) const { return live_.count(path) > 0; }

    /// One of the disks that a cut now may leave, below `at`.
    void cut(const std::filesystem::path& at, std::mt19937_64& random) const {
        std::map<std::string, size_t> names = durable_;
        const bool in_order = random() % 2 == 0;
        const size_t first = random() % (changes_.size() + 1);
        for (size_t i = 0; i < changes_.size(); ++i) {
            if (in_order ? i < first : random() % 2 == 0) perform(changes_[i], names);
        }
        for (const std::string& folder : folders_) {
            std::filesystem::create_directories(at / relative(folder));
        }
        // The 16 MiB are of no interest here.
        std::ofstream(at / "ballast", std::ios::binary) << "-";
        for (const auto& [path, file] : names) {
            std::ofstream(at / relative(path), std::ios::binary) << content(files_[file], random);
        }
    }

  private:
    struct File {
        std::string synced;
        std::vector<DiskOp> pending;
    };
    /// A name that comes (`to`), goes (`from`) or both.
    struct Change {
        std::string folder;
        std::string from;
        std::string to;
        size_t file = 0;
    };

    static std::vector<std::string> lines_of(const std::string& text) {
        std::vector<std::string> lines;
        std::istringstream in(text);
        for (std::string line; std::getline(in, line);) lines.push_back(line);
        return lines;
    }
    static std::string folder_of(const std::string& path) {
        return path.substr(0, path.rfind('/'));
    }
    std::string relative(const std::string& path) const {
        return path.size() > root_.size() ? path.substr(root_.size() + 1) : ".";
    }
    void change(Change change) { changes_.push_back(std::move(change)); }
    static void perform(const Change& change, std::map<std::string, size_t>& names) {
        if (!change.from.empty()) names.erase(change.from);
        if (!change.to.empty()) names[change.to] = change.file;
    }
    static void perform(const DiskOp& op, std::string& content) {
        if (op.kind == DiskOp::kTruncate) {
            content.resize(op.offset);
            return;
        }
        content.resize(std::max<size_t>(content.size(), op.offset + op.data.size()));
        content.replace(op.offset, op.data.size(), op.data);
    }
    void sync(const std::string& path) {
        if (const auto at = live_.find(path); at != live_.end()) {
            File& file = files_[at->second];
            for (const DiskOp& op : file.pending) perform(op, file.synced);
            file.pending.clear();
            return;
        }
        std::vector<Change> left;
        for (Change& change : changes_) {
            if (change.folder == path) {
                perform(change, durable_);
            } else {
                left.push_back(std::move(change));
            }
        }
        changes_ = std::move(left);
    }
    /// How much of what was written since the last fsync arrived: nothing, everything, some.
    static std::string content(const File& file, std::mt19937_64& random) {
        std::string content = file.synced;
        const uint64_t how = random() % 4;
        if (how == 0) return content;
        for (const DiskOp& op : file.pending) {
            if (how == 1 || op.kind == DiskOp::kTruncate) {
                if (how == 1 || random() % 2 == 0) perform(op, content);
                continue;
            }
            constexpr size_t kSector = 512;
            for (size_t begin = 0; begin < op.data.size();) {
                const size_t end = std::min<size_t>(
                    op.data.size(), (op.offset + begin) / kSector * kSector + kSector - op.offset);
                if (random() % 2 == 0) {
                    DiskOp part{DiskOp::kWrite, "", "", op.offset + begin,
                                op.data.substr(begin, end - begin)};
                    perform(part, content);
                }
                begin = end;
            }
        }
        return content;
    }

    const std::string root_;
    std::vector<File> files_;
    std::map<std::string, size_t> live_;     // names as the program sees them
    std::map<std::string, size_t> durable_;  // as the disk has them for sure
    std::vector<Change> changes_;            // of names, since the last fsync of their folder
    std::vector<std::string> folders_;
    Promises promises_;
};

}  // namespace probebake::test
