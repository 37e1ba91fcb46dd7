#include "media.h"

#include <array>

namespace tyndall::bench {
namespace {

scene::NoiseCloud cloud(int octaves, double contrast, double coverage, double falloff) {
  scene::NoiseCloud c;
  c.octaves = octaves;
  c.gain = 0.5;
  c.seed = 34;
  c.contrast = contrast;
  c.coverage = coverage;
  c.falloff = falloff;
  c.body = scene::Sphere{{0.5, 0.5, 0.5}, 0.5};
  return c;
}

scene::Component component(scene::Field field, double extinction, double albedo) {
  scene::Component c;
  c.field = std::move(field);
  c.extinction = extinction;
  c.albedo = glm::dvec3(albedo);
  return c;
}

struct PaperRow {
  int table;
  const char* scene;
  int octaves;
  std::array<double, 3> rates;  // ray marching, Woodcock, super-voxels
};

constexpr PaperRow paper[] = {{1, "LV", 8, {1.1, 3.3, 9.1}},    {1, "HV", 8, {1.0, 2.0, 8.1}},
                              {1, "LV", 12, {0.05, 2.2, 5.2}},  {1, "HV", 12, {0.05, 1.2, 4.9}},
                              {2, "LV", 8, {1.1, 3.3, 9.1}},    {2, "LV", 9, {0.5, 2.9, 7.8}},
                              {2, "LV", 11, {0.1, 2.5, 7.1}},   {2, "LV", 13, {0.02, 2.0, 5.8}},
                              {2, "LV", 15, {0.005, 1.6, 5.1}}, {3, "fog", 12, {0.04, 2.1, 4.9}}};

}  // namespace

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> list;
    for (const PaperRow& row : paper)
      list.push_back({row.table, row.scene, row.octaves, row.table == 3 ? 64 : 16});
    // The paper's second table has only its low-variation cloud; this adds the other one.
    for (const int octaves : {8, 9, 11, 13, 15}) list.push_back({2, "HV", octaves, 16});
    return list;
  }();
  return all;
}

Scene scene_of(const Case& which, int super_voxels) {
  Scene scene;
  if (which.scene == "LV") {
    scene.medium.components = {component(cloud(which.octaves, 0.5, 1.4, 1.8), 128, 1)};
  } else if (which.scene == "HV") {
    scene.medium.components = {component(cloud(which.octaves, 3, 0, 0.45), 539, 1)};
  } else {
    scene::NoiseCloud fog = cloud(which.octaves, 0.5, 0.8, 0);
    fog.body = scene::Everywhere{};
    scene.medium.components = {
        component(fog, 20, 1),
        component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.2}}, 1000, 0)};
  }
  scene.medium.majorant_resolution = {super_voxels, super_voxels, super_voxels};
  scene.illumination_resolution = {64, 64, 64};
  scene.illumination_order = 0;
  scene.seed = 1;
  return scene;
}

PreparedScene prepare_case(const Case& which, int super_voxels, int threads, double table_points) {
  PreparedScene scene = prepare(ResolvedScene::unchecked(scene_of(which, super_voxels)), threads,
                                {}, {}, table_points);
  // Its cone holds the disc of radius 0.5 across the middle of the box.
  lights::Point light;
  light.position = {0.5f, 0.5f, -1.5f};
  light.cone.height = 0.029857499f;  // 1 - cos(atan(1/4))
  scene.emitters = {Emitter{light}};
  scene.emitters[0].last_word = 0xffffffffu;
  scene.shot_power = 1;
  scene.cells.channels = 1;
  return scene;
}

double paper_rate(const Case& which, const std::string& sampler) {
  for (const PaperRow& row : paper) {
    if (row.table != which.table || row.scene != which.scene || row.octaves != which.octaves)
      continue;
    if (sampler == "ray_marching") return row.rates[0];
    if (sampler == "woodcock") return row.rates[1];
    if (sampler == "super_voxel_2011") return row.rates[2];
  }
  return 0;
}

}  // namespace tyndall::bench
