// ProbeAttributes in the header of an EXR file, there and back.
#pragma once

#include <ImfEnvmap.h>
#include <ImfHeader.h>

#include <optional>

#include "image/exr.h"

namespace probebake {

/// The header of a file with these attributes, its channels still to come. Throws
/// std::invalid_argument for a name that cannot be written.
Imf::Header make_header(int width_px, int height_px, std::optional<Imf::Envmap> layout,
                        const ProbeAttributes& attributes);
/// The same of a cube-face file; throws for a face size that cannot be written, too.
Imf::Header make_cube_header(int face_size, const ProbeAttributes& attributes);

/// Throws IoError with `file` where an attribute has another type than it is written with, where
/// the file is no cube-face environment map or where its primaries are not Rec.709.
ProbeAttributes read_cube_header(const Imf::Header& header, const std::string& file);

}  // namespace probebake
