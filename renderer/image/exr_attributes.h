// ProbeAttributes in the header of an EXR file, there and back.
#pragma once

#include <ImfHeader.h>

#include "image/exr.h"

namespace probebake {

/// The header of a cube-face file with these attributes, its channels still to come. Throws
/// std::invalid_argument for a face size or a name that cannot be written.
Imf::Header make_cube_header(int face_size, const ProbeAttributes& attributes);

/// Throws IoError with `file` where an attribute has another type than it is written with, where
/// the file is no cube-face environment map or where its primaries are not Rec.709.
ProbeAttributes read_cube_header(const Imf::Header& header, const std::string& file);

}  // namespace probebake
