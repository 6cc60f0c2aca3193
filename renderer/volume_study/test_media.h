// The media and the sky that trackers are compared on.
#pragma once

#include "light/lighting.h"
#include "volume_study/clouds.h"

namespace probebake::volume_study {

struct TestMedium {
    const char* name;
    const char* title;
    double column;
    Rgb absorb;
    Rgb scatter;
};

/// Gray, 1:2:4, figure 4's absorbing medium, coloured albedo 1, 1:10:100.
const std::vector<TestMedium>& test_media();

/// The cloud of such a medium, g = 0.6.
Media media_of(const Cloud& cloud, const TestMedium& medium);

/// A sky gradient without a sun.
Lighting test_sky();

}  // namespace probebake::volume_study
