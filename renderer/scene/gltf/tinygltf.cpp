// The one place that compiles tinygltf; without our warnings, as it is not our code.
#include <fstream>  // its writer needs it, and includes it only where it reads files itself

#define TINYGLTF_IMPLEMENTATION
#include "scene/gltf/tinygltf.h"
