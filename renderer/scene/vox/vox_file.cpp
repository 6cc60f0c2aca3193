#include "scene/vox/vox_file.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "io/byte_reader.h"
#include "scene/vox/vox_dictionary.h"

namespace probebake {
namespace {

class Parser {
  public:
    Parser(std::span<const std::byte> bytes, const std::string& file_name)
        : reader_(file_name, bytes) {
        out_.palette = default_vox_palette();
    }

    VoxFile parse() {
        if (reader_.take_text(4, "the magic") != "VOX ") {
            reader_.fail_at(0, "is not a MagicaVoxel file");
        }
        const auto version = reader_.read<int32_t>("the version");
        if (version != 150 && version != 200) {
            reader_.fail_at(4, "has version " + std::to_string(version) + ", expected 150 or 200");
        }
        const Chunk main = read_chunk(reader_);
        if (main.id != "MAIN") main.content.fail_at(8, "expected chunk MAIN");
        if (!reader_.done()) {
            reader_.fail("chunk MAIN ends here, but " + std::to_string(reader_.remaining()) +
                         " bytes follow");
        }
        ByteReader children = main.children;
        while (!children.done()) {
            Chunk chunk = read_chunk(children);
            read_known(chunk);
        }
        finish(main);
        return std::move(out_);
    }

  private:
    struct Chunk {
        uint64_t offset_bytes;
        std::string id;
        ByteReader content;
        ByteReader children;
    };

    static Chunk read_chunk(ByteReader& reader) {
        const uint64_t offset = reader.offset();
        const std::string id(reader.take_text(4, "the id of a chunk"));
        const auto content_bytes = reader.read<uint32_t>("the size of a chunk");
        const auto children_bytes = reader.read<uint32_t>("the size of a chunk's children");
        const std::string name = "chunk " + printable(id);
        const uint64_t needed = uint64_t{content_bytes} + children_bytes;
        if (needed > reader.remaining()) {
            reader.fail_at(offset, name + " has " + std::to_string(content_bytes) +
                                       " bytes of content and " + std::to_string(children_bytes) +
                                       " of children, " + std::to_string(reader.remaining()) +
                                       " are left");
        }
        ByteReader content = reader.part(content_bytes, "the content", name);
        return {offset, id, std::move(content), reader.part(children_bytes, "the children", name)};
    }

    void read_known(Chunk& chunk) {
        if (size_at_ && chunk.id != "XYZI") fail_without_voxels();
        if (chunk.id == "PACK") {
            pack_at_ = chunk.content.offset();
            packed_models_ = chunk.content.read<uint32_t>("the number of models");
        } else if (chunk.id == "SIZE") {
            read_size(chunk);
        } else if (chunk.id == "XYZI") {
            read_voxels(chunk);
        } else if (chunk.id == "RGBA") {
            read_palette(chunk);
        } else if (chunk.id == "IMAP") {
            read_index_map(chunk);
        } else if (chunk.id == "MATL") {
            read_material(chunk.content);
        } else if (chunk.id == "LAYR") {
            read_layer(chunk.content);
        } else if (chunk.id == "nTRN") {
            read_transform(chunk);
        } else if (chunk.id == "nGRP") {
            read_group(chunk);
        } else if (chunk.id == "nSHP") {
            read_shape(chunk);
        } else {
            if (chunk.id == "MATT") warn("the old materials of chunk MATT are ignored");
            return;
        }
        if (!chunk.content.done()) {
            chunk.content.fail("holds " + std::to_string(chunk.content.remaining()) +
                               " more bytes than its contents need");
        }
    }

    void read_size(Chunk& chunk) {
        size_at_ = chunk.offset_bytes;
        for (int axis = 0; axis < 3; ++axis) {
            const uint64_t at = chunk.content.offset();
            size_[axis] = chunk.content.read<int32_t>("the size of a model");
            if (size_[axis] < 1 || size_[axis] > kMaxVoxModelSize) {
                chunk.content.fail_at(at, "the model's size is " + std::to_string(size_[axis]) +
                                              ", expected 1 to " +
                                              std::to_string(kMaxVoxModelSize));
            }
        }
    }

    void read_voxels(Chunk& chunk) {
        if (!size_at_) chunk.content.fail_at(chunk.offset_bytes, "has no SIZE chunk before it");
        size_at_.reset();
        const auto count = chunk.content.read<uint32_t>("the number of voxels");
        if (uint64_t{count} * 4 != chunk.content.remaining()) {
            chunk.content.fail("says that it has " + std::to_string(count) +
                               " voxels of 4 bytes, " + std::to_string(chunk.content.remaining()) +
                               " bytes follow");
        }
        const uint64_t begin = chunk.content.offset();
        const auto bytes = chunk.content.take(uint64_t{count} * 4, "the voxels");
        const auto voxel = [&](size_t i) {
            VoxModelVoxel v;
            std::memcpy(v.position.data(), &bytes[4 * i], 3);
            v.color = std::to_integer<uint8_t>(bytes[4 * i + 3]);
            return v;
        };
        const auto cell = [&](const VoxModelVoxel& v) {
            const auto [x, y, z] = v.position;
            const int index = (z * size_.y + y) * size_.x + x;
            return static_cast<size_t>(index);
        };

        VoxModel model{.offset_bytes = chunk.offset_bytes, .size = size_};
        model.voxels.reserve(count);
        const int cells = size_.x * size_.y * size_.z;
        taken_.resize(std::max(taken_.size(), static_cast<size_t>(cells)));
        for (size_t i = count; i-- > 0;) {  // backwards: the last of several counts
            const VoxModelVoxel v = voxel(i);
            const IVec3 p(v.position[0], v.position[1], v.position[2]);
            if (glm::any(glm::greaterThanEqual(p, size_))) {
                chunk.content.fail_at(
                    begin + 4 * i, "voxel " + std::to_string(i) + " lies outside its model's size");
            }
            if (taken_[cell(v)]) continue;
            taken_[cell(v)] = true;
            if (v.color == 0) continue;
            const bool first = model.voxels.empty();
            model.lowest = first ? p : glm::min(model.lowest, p);
            model.highest = first ? p : glm::max(model.highest, p);
            model.voxels.push_back(v);
        }
        // Undone one by one: clearing it all per model would cost more than a small model does.
        for (size_t i = 0; i < count; ++i) taken_[cell(voxel(i))] = false;
        out_.models.push_back(std::move(model));
    }

    void read_palette(Chunk& chunk) {
        // Colour i of the file is that of index i + 1; the last is not used.
        for (size_t i = 1; i <= 256; ++i) {
            const auto color = chunk.content.read<std::array<uint8_t, 4>>("the palette");
            if (i < 256) out_.palette[i] = color;
        }
    }

    /// IMAP is the order in which the editor shows the palette: its k-th colour is entry IMAP[k].
    /// Voxels and materials keep the entry's own index (ogt_vox.h of opengametools renumbers
    /// voxels, colours and materials alike), so no colour changes.
    void read_index_map(Chunk& chunk) {
        std::array<bool, 256> seen{};
        for (size_t k = 0; k < 256; ++k) seen[chunk.content.read<uint8_t>("the index map")] = true;
        if (std::find(seen.begin(), seen.end(), false) != seen.end()) {
            warn("the order of the palette in chunk IMAP names entries twice and is ignored");
        }
    }

    void read_material(ByteReader& content) {
        const uint64_t at = content.offset();
        const auto id = content.read<int32_t>("the id of a material");
        if (id < 0 || id > 256) {
            content.fail_at(at,
                            "the material's id is " + std::to_string(id) + ", expected 0 to 256");
        }
        const VoxDictionary properties(content);
        const std::string_view type = properties.text("_type");
        VoxMaterial material;
        if (type == "_emit") {
            // Early files have no _emit: there _weight says how far the type applies.
            const char* key = properties.text("_emit").empty() ? "_weight" : "_emit";
            material.emit = properties.number(key, kMaxVoxEmit);
            material.flux = properties.number("_flux", kMaxVoxFlux);
        } else if (!type.empty() && type != "_diffuse") {
            warn("materials other than _diffuse and _emit are taken as diffuse");
        }
        out_.materials[static_cast<size_t>(id) & 255u] = material;  // 256 stands for 0
    }

    void read_layer(ByteReader& content) {
        const uint64_t at = content.offset();
        const auto id = content.read<int32_t>("the id of a layer");
        if (id < 0) {
            content.fail_at(at, "the layer's id is " + std::to_string(id) + ", expected 0 or more");
        }
        const VoxDictionary attributes(content);
        content.read<int32_t>("the reserved id");
        if (attributes.hidden()) hidden_layers_.push_back(id);
    }

    VoxNode& add_node(const Chunk& chunk, VoxNode::Kind kind, int32_t id, bool hidden) {
        VoxNode node;
        node.kind = kind;
        node.id = id;
        node.offset_bytes = chunk.offset_bytes;
        node.hidden = hidden;
        return out_.nodes.emplace_back(std::move(node));
    }

    void read_transform(Chunk& chunk) {
        ByteReader& content = chunk.content;
        const auto id = content.read<int32_t>("the id of a node");
        const bool hidden = VoxDictionary(content).hidden();
        VoxNode& node = add_node(chunk, VoxNode::Kind::kTransform, id, hidden);
        node.references.push_back(content.read<uint32_t>("the child's id"));
        content.read<int32_t>("the reserved id");
        node.layer = content.read<int32_t>("the layer's id");
        const uint64_t at = content.offset();
        const auto frames = content.read<uint32_t>("the number of frames");
        if (frames == 0) content.fail_at(at, "has no frame, expected at least one");
        if (frames > 1) warn_of_animation();
        for (uint32_t frame = 0; frame < frames; ++frame) {
            const VoxDictionary attributes(content);
            if (frame == 0) node.transform = attributes.transform();
        }
    }

    void read_group(Chunk& chunk) {
        ByteReader& content = chunk.content;
        const auto id = content.read<int32_t>("the id of a node");
        const bool hidden = VoxDictionary(content).hidden();
        VoxNode& node = add_node(chunk, VoxNode::Kind::kGroup, id, hidden);
        const auto count = content.read<uint32_t>("the number of children");
        if (uint64_t{count} * 4 != content.remaining()) {
            content.fail("says that it has " + std::to_string(count) + " children of 4 bytes, " +
                         std::to_string(content.remaining()) + " bytes follow");
        }
        node.references.resize(count);
        for (uint32_t& child : node.references) child = content.read<uint32_t>("a child's id");
    }

    void read_shape(Chunk& chunk) {
        ByteReader& content = chunk.content;
        const auto id = content.read<int32_t>("the id of a node");
        const bool hidden = VoxDictionary(content).hidden();
        VoxNode& node = add_node(chunk, VoxNode::Kind::kShape, id, hidden);
        const uint64_t at = content.offset();
        const auto count = content.read<uint32_t>("the number of models");
        if (count == 0) content.fail_at(at, "has no model, expected at least one");
        if (count > 1) warn_of_animation();
        for (uint32_t i = 0; i < count; ++i) {
            node.references.push_back(content.read<uint32_t>("a model's id"));
            const VoxDictionary attributes(content);
        }
    }

    void finish(const Chunk& main) {
        if (size_at_) fail_without_voxels();
        if (out_.models.empty()) main.content.fail_at(main.offset_bytes, "holds no model");
        if (pack_at_ && packed_models_ != out_.models.size()) {
            reader_.fail_at(*pack_at_,
                            "chunk PACK: says that there are " + std::to_string(packed_models_) +
                                " models, the file has " + std::to_string(out_.models.size()));
        }
        link_nodes();
    }

    /// Sorts the nodes and turns ids into indices.
    void link_nodes() {
        std::vector<VoxNode>& nodes = out_.nodes;
        const auto by_id = [](const VoxNode& a, const VoxNode& b) { return a.id < b.id; };
        std::stable_sort(nodes.begin(), nodes.end(), by_id);
        for (size_t i = 1; i < nodes.size(); ++i) {
            if (nodes[i].id == nodes[i - 1].id) fail(nodes[i], "occurs twice");
        }
        if (!nodes.empty() && nodes[0].id != 0) fail(nodes[0], "is the lowest, expected a root 0");
        std::sort(hidden_layers_.begin(), hidden_layers_.end());
        for (VoxNode& node : nodes) {
            node.hidden |=
                std::binary_search(hidden_layers_.begin(), hidden_layers_.end(), node.layer);
            for (uint32_t& reference : node.references) {
                reference = node.kind == VoxNode::Kind::kShape ? checked_model(node, reference)
                                                               : node_index(node, reference);
            }
        }
    }

    uint32_t checked_model(const VoxNode& node, uint32_t model) const {
        if (model >= out_.models.size()) {
            fail(node, "names model " + std::to_string(model) + ", the file has " +
                           std::to_string(out_.models.size()) + " models");
        }
        return model;
    }

    uint32_t node_index(const VoxNode& node, uint32_t child) const {
        const auto id = static_cast<int32_t>(child);
        const auto found = std::lower_bound(
            out_.nodes.begin(), out_.nodes.end(), id,
            [](const VoxNode& other, int32_t wanted) { return other.id < wanted; });
        if (found == out_.nodes.end() || found->id != id) {
            fail(node, "has child " + std::to_string(id) + ", which is no node of the file");
        }
        return static_cast<uint32_t>(found - out_.nodes.begin());
    }

    void warn(const char* text) {
        if (std::find(out_.warnings.begin(), out_.warnings.end(), text) == out_.warnings.end()) {
            out_.warnings.emplace_back(text);
        }
    }
    void warn_of_animation() { warn("only the first frame of an animation is taken"); }

    [[noreturn]] void fail(const VoxNode& node, const std::string& problem) const {
        reader_.fail_at(node.offset_bytes, name_of(node) + " " + problem);
    }
    [[noreturn]] void fail_without_voxels() const {
        reader_.fail_at(*size_at_, "chunk SIZE: is not followed by a chunk XYZI");
    }

    ByteReader reader_;
    VoxFile out_;
    std::optional<uint64_t> size_at_;  // set while SIZE waits for its XYZI
    IVec3 size_{0};
    std::vector<bool> taken_;  // cells of the model being read; all false in between
    std::optional<uint64_t> pack_at_;
    uint32_t packed_models_ = 0;
    std::vector<int32_t> hidden_layers_;
};

}  // namespace

std::string name_of(const VoxNode& node) {
    const char* chunk = node.kind == VoxNode::Kind::kTransform ? "nTRN"
                        : node.kind == VoxNode::Kind::kGroup   ? "nGRP"
                                                               : "nSHP";
    return std::string("chunk ") + chunk + ": node " + std::to_string(node.id);
}

VoxFile parse_vox(std::span<const std::byte> bytes, const std::string& file_name) {
    return Parser(bytes, file_name).parse();
}

}  // namespace probebake
