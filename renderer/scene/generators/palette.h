// Linear Rec.709 reflectances of natural and built materials (0.02 wet earth to 0.85 fresh snow).
#pragma once

#include "math/vec.h"

namespace probebake::worldgen::palette {

inline constexpr Rgb kSnow{0.80f, 0.83f, 0.87f};
inline constexpr Rgb kSnowShade{0.62f, 0.68f, 0.77f};
inline constexpr Rgb kIce{0.42f, 0.56f, 0.64f};
inline constexpr Rgb kWater{0.035f, 0.085f, 0.095f};
inline constexpr Rgb kShallows{0.11f, 0.17f, 0.14f};
inline constexpr Rgb kFoam{0.45f, 0.52f, 0.54f};

inline constexpr Rgb kGranite{0.23f, 0.22f, 0.21f};
inline constexpr Rgb kGraniteDark{0.10f, 0.098f, 0.10f};
inline constexpr Rgb kGraniteWarm{0.27f, 0.225f, 0.18f};
inline constexpr Rgb kLichen{0.24f, 0.25f, 0.12f};
inline constexpr Rgb kSandstoneRed{0.42f, 0.17f, 0.085f};
inline constexpr Rgb kSandstoneOrange{0.52f, 0.27f, 0.125f};
inline constexpr Rgb kSandstonePale{0.58f, 0.43f, 0.27f};
inline constexpr Rgb kSandstoneDark{0.22f, 0.10f, 0.06f};
inline constexpr Rgb kSand{0.52f, 0.37f, 0.21f};
inline constexpr Rgb kSandLight{0.60f, 0.46f, 0.29f};
inline constexpr Rgb kGravel{0.27f, 0.23f, 0.185f};

inline constexpr Rgb kEarth{0.115f, 0.075f, 0.045f};
inline constexpr Rgb kForestFloor{0.085f, 0.060f, 0.033f};
inline constexpr Rgb kMoss{0.075f, 0.105f, 0.030f};
inline constexpr Rgb kGrass{0.085f, 0.135f, 0.033f};
inline constexpr Rgb kGrassDry{0.29f, 0.235f, 0.095f};
inline constexpr Rgb kGrassAlpine{0.17f, 0.18f, 0.065f};
inline constexpr Rgb kPath{0.25f, 0.19f, 0.125f};

inline constexpr Rgb kSpruce{0.027f, 0.058f, 0.026f};
inline constexpr Rgb kPine{0.045f, 0.078f, 0.028f};
inline constexpr Rgb kLarch{0.23f, 0.15f, 0.030f};
inline constexpr Rgb kBeech{0.078f, 0.122f, 0.032f};
inline constexpr Rgb kBirchLeaf{0.15f, 0.18f, 0.045f};
inline constexpr Rgb kMaple{0.30f, 0.085f, 0.025f};
inline constexpr Rgb kPalm{0.090f, 0.135f, 0.040f};
inline constexpr Rgb kAcacia{0.115f, 0.125f, 0.045f};
inline constexpr Rgb kJuniper{0.075f, 0.09f, 0.045f};
inline constexpr Rgb kSage{0.175f, 0.185f, 0.115f};
inline constexpr Rgb kCactus{0.085f, 0.135f, 0.065f};

inline constexpr Rgb kBark{0.095f, 0.070f, 0.050f};
inline constexpr Rgb kBarkPine{0.19f, 0.105f, 0.060f};
inline constexpr Rgb kBirchBark{0.56f, 0.54f, 0.49f};
inline constexpr Rgb kDeadWood{0.27f, 0.245f, 0.215f};
inline constexpr Rgb kTimber{0.21f, 0.13f, 0.070f};
inline constexpr Rgb kTimberDark{0.085f, 0.055f, 0.034f};
inline constexpr Rgb kThatch{0.34f, 0.26f, 0.125f};
inline constexpr Rgb kSlate{0.085f, 0.092f, 0.105f};
inline constexpr Rgb kMasonry{0.30f, 0.28f, 0.25f};
inline constexpr Rgb kGlass{0.045f, 0.055f, 0.065f};

}  // namespace probebake::worldgen::palette
