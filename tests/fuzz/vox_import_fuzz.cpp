// import_vox on anything: a world that holds what it promises, or an IoError within the file.
//
// Each input is tried twice: as it is, and with the size in MAIN's header put right, so that the
// fuzzer may lengthen and shorten files without ever learning that number.
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "io/io_error.h"
#include "scene/vox/vox_import.h"
#include "voxels/voxel_tree.h"

namespace {

using namespace probebake;

void require(bool holds) {
    if (!holds) std::abort();
}

void import_and_check(std::span<const std::byte> bytes) {
    VoxLimits limits;
    limits.max_voxels = 1 << 18;
    limits.max_instances = 1 << 12;
    limits.max_node_visits = 1 << 14;
    try {
        VoxImport result = import_vox(bytes, "fuzz.vox", limits);
        const size_t count = result.cloud.voxels.size();
        require(count <= limits.max_voxels);
        require(result.instances <= limits.max_instances);
        require(result.emissive_voxels <= count);
        int exponent = 0;
        require(std::frexp(result.cloud.emission_scale, &exponent) == 0.5f);
        require(result.warnings.size() < 10);
        // Throws std::invalid_argument for a voxel outside its world.
        BuildStats stats;
        const VoxelTree tree = VoxelTree::build(std::move(result.cloud), &stats);
        require(tree.voxel_count() + stats.duplicates == count);
    } catch (const IoError& error) {
        require(error.offset_bytes().has_value() && *error.offset_bytes() <= bytes.size());
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const auto bytes = std::as_bytes(std::span(data, size));
    import_and_check(bytes);
    constexpr size_t kHeaderBytes = 20;
    if (size < kHeaderBytes) return 0;
    std::vector<std::byte> repaired(bytes.begin(), bytes.end());
    const auto children_bytes = static_cast<uint32_t>(size - kHeaderBytes);
    std::memcpy(&repaired[kHeaderBytes - sizeof(children_bytes)], &children_bytes,
                sizeof(children_bytes));
    import_and_check(repaired);
    return 0;
}
