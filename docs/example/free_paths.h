// Free paths through a cloud of 4096^3 effective voxels, in a loop of one's own. The text is that of host and device.
#include "tyndall/render/prepare.h"
#include "tyndall/scene/scene.h"

using Cloud = tyndall::SingleMedium<tyndall::NoiseCloud>;

inline tyndall::Scene cloud_scene() {
  tyndall::scene::NoiseCloud field;
  field.octaves = 12;
  tyndall::Scene scene;
  scene.medium.components.push_back({field, 40.0, glm::dvec3(1), {}, {}, glm::dmat4(1)});
  scene.lights = {tyndall::scene::EnvironmentLight{}};
  return scene;
}

/// How far photon `i` flies from the middle of the face x = 0 along +x; more than 1: through.
TYN_HD float fly(const Cloud& cloud, unsigned i) {
  const tyndall::RandomStream random{1, i, tyndall::Domain::photon};
  const float tau = tyndall::exponential(random.block(0, tyndall::Purpose::emission).d);
  tyndall::Path path{{{0, 0.5f, 0.5f}, {1, 0, 0}}, tau, 0, {}};
  tyndall::Audit audit;
  const tyndall::Flight flight = tyndall::SuperVoxel{}.fly(cloud, path, random, audit);
  return flight.end == tyndall::Flight::End::collided ? flight.length : 2.0f;
}
