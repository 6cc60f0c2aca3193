#include "volume_study/test_media.h"

namespace probebake::volume_study {

const std::vector<TestMedium>& test_media() {
    static const std::vector<TestMedium> media = {
        {"gray", "gray, albedo 0.99", 30.0, Rgb(0.01f), Rgb(0.99f)},
        {"ratio_124", "extinction 1:2:4, albedo 0.9", 30.0, Rgb(0.1f, 0.2f, 0.4f),
         Rgb(0.9f, 1.8f, 3.6f)},
        {"figure_4", "figure 4: absorption .2:.3:.6, scattering 1.1:1.2:1.0", 30.0,
         Rgb(0.2f, 0.3f, 0.6f), Rgb(1.1f, 1.2f, 1.0f)},
        {"albedo_1", "extinction .5:1:1.4, albedo 1", 20.0, Rgb(0.0f), Rgb(0.5f, 1.0f, 1.4f)},
        {"ratio_1_10_100", "extinction 1:10:100, albedo 0.9", 100.0, Rgb(0.1f, 1.0f, 10.0f),
         Rgb(0.9f, 9.0f, 90.0f)},
    };
    return media;
}

Media media_of(const Cloud& cloud, const TestMedium& medium) {
    return Media({cloud_medium(cloud, medium.column, medium.absorb, medium.scatter, 0.6)},
                 {.max_depth = 7, .threshold = 0.5});
}

Lighting test_sky() {
    Lighting lighting;
    lighting.sky = Sky(SkyGradient{Rgb(0.5f, 0.7f, 1.0f), Rgb(1.0f), Rgb(0.2f)});
    return lighting;
}

}  // namespace probebake::volume_study
