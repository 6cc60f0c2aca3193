// A view by the hybrid renderer (hybrid.h).
//
// Without a ray limit every pixel goes its own way after the first rays. With one, pixels go on in
// rounds, a quarter of those that wait at a time, the largest predicted gains first, as long as the
// rays last: a priority queue in parallel steps, the same for any number of threads.
#pragma once

#include "render/render.h"

namespace probebake {

ViewRender render_hybrid_view(const RenderScene& scene, const View& view,
                              const RenderSettings& settings, const CancelToken& cancel,
                              const ViewExtent& extent);

}  // namespace probebake
