// Renders of meshes for previews.
#pragma once

#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "tools/inspect/preview.h"
#include "transport/camera.h"
#include "transport/cpu_renderer.h"
#include "transport/lights.h"

namespace bakelight::inspect {

inline constexpr double kMiddleValue =
    0.4;  // linear; where the mean goes; lighter than the player's, as clay is all there is
inline constexpr int kSupersampling = 3;     // a pixel's subsamples, by side
inline constexpr float kClayAlbedo = 0.65f;  // so that the lit side keeps its form

// Throws Error(kBadInput) naming `file` if the mesh has no extent.
transport::OrbitCamera cameraFor(const formats::TriangleMesh& mesh, const PreviewOptions& options,
                                 const std::string& file);

// Brings the mean of the light to the middle value.
double exposureFor(const transport::ShLight& light);
double defaultExposure();

// Exit radiance at the vertices of a clay body without shadows under transport::defaultLight; with smooth
// normals if the mesh has none.
std::vector<formats::Float3> clayRadiance(const formats::TriangleMesh& mesh);

// Before a dark backdrop of the same brightness at any exposure.
transport::CpuPicture takePicture(const formats::TriangleMesh& mesh, const transport::RadianceAtHits& shade,
                                  const transport::OrbitCamera& camera, double exposure,
                                  const PreviewOptions& options);

// takePicture, encoded for display.
formats::Image render(const formats::TriangleMesh& mesh, const transport::RadianceAtHits& shade,
                      const transport::OrbitCamera& camera, double exposure, const PreviewOptions& options);

}  // namespace bakelight::inspect
