// tyndall._core: what the Python package calls. Arrays and dictionaries in, arrays and dictionaries
// out.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/report.h"
#include "io/scene_json.h"
#include "session/devices.h"
#include "session/memory.h"
#include "tyndall/render/bake.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

namespace py = pybind11;

/// (pass, share of it that is done); false stops the work.
using Callback = std::function<bool(const std::string&, double)>;

/// Tells the callback now and then, and looks for Ctrl-C. Called without the interpreter's lock.
class Watch {
 public:
  explicit Watch(Callback callback) : callback_(std::move(callback)) {}

  RenderOptions options() {
    RenderOptions options;
    options.progress = [this](const Progress& progress) {
      const auto now = std::chrono::steady_clock::now();
      const bool is_end = progress.done == progress.total;
      if (!is_end && now - last_ < std::chrono::milliseconds(100)) return;
      last_ = now;
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      const double share = progress.total > 0 ? static_cast<double>(progress.done)
                                                    / static_cast<double>(progress.total)
                                              : 1.0;
      if (callback_ && !callback_(progress.pass, share)) is_stopped_ = true;
    };
    options.stop = [this] { return is_stopped_; };
    return options;
  }

 private:
  const Callback callback_;
  std::chrono::steady_clock::time_point last_{};
  bool is_stopped_ = false;
};

py::array_t<float> array(std::vector<py::ssize_t> shape, const float* values) {
  return py::array_t<float>(std::move(shape), values);
}

py::array_t<float> cells(const std::array<int, 3>& size, const std::vector<Vec3f>& colors) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  return array({size[2], size[1], size[0], 3}, &colors.data()->x);
}

py::dict facts(const RenderResult& result) {
  py::dict out;
  for (const auto& [key, value] : io::provenance(result)) out[py::str(key)] = value;
  return out;
}

struct Work {
  io::SceneFile file;
  std::unique_ptr<Backend> backend;
};

/// What the command line would say: of the scene, and of the result what was not said of that.
std::vector<std::string> all_warnings(const Work& work, const RenderResult& result) {
  std::vector<std::string> all = work.file.warnings;
  for (std::string& warning : io::unsaid_warnings(result, all)) all.push_back(std::move(warning));
  return all;
}

void require_memory(const Scene& scene, int lights) {
  if (const std::string shortage = session::memory_shortage(scene, lights); !shortage.empty())
    throw Error(ExitCode::out_of_memory, shortage);
}

Work prepare_work(const std::string& name, const std::string& text, const std::string& folder,
                  const std::vector<std::string>& overrides, const std::string& device,
                  int threads) {
  Work work{io::read_scene_text(name, text, folder, overrides), nullptr};
  work.backend = session::open_device(session::parse_device(device), threads).backend;
  return work;
}

py::dict render_text(const std::string& name, const std::string& text, const std::string& folder,
                     const std::vector<std::string>& overrides, const std::string& device,
                     int threads, Callback progress) {
  RenderResult result;
  std::vector<std::string> warnings;
  {
    const py::gil_scoped_release no_lock;
    Watch watch(std::move(progress));
    const Work work = prepare_work(name, text, folder, overrides, device, threads);
    require_memory(work.file.scene, 1);
    result = render(work.file.scene, *work.backend, watch.options());
    warnings = all_warnings(work, result);
  }
  const Picture& picture = result.picture;
  py::dict layers;
  for (const PictureLayer& layer : picture.layers)
    layers[py::str(layer.name)] =
        array({picture.height, picture.width, static_cast<py::ssize_t>(layer.channels.size())},
              layer.values.data());
  py::dict out;
  out["picture"] = array({picture.height, picture.width, 4}, picture.rgba.data());
  out["layers"] = layers;
  out["tallies"] = fmt::format("{:016x}", result.hashes.tallies);
  out["pixels"] = fmt::format("{:016x}", result.hashes.pixels);
  out["facts"] = facts(result);
  out["warnings"] = warnings;
  return out;
}

py::dict bake_text(const std::string& name, const std::string& text, const std::string& folder,
                   const std::vector<std::string>& overrides, const std::string& device,
                   int threads, Callback progress, bool with_directions, bool per_light,
                   bool multiple_only) {
  BakedLight light;
  RenderResult result;
  std::vector<std::string> warnings;
  {
    const py::gil_scoped_release no_lock;
    Watch watch(std::move(progress));
    const Work work = prepare_work(name, text, folder, overrides, device, threads);
    const Scene scene = scene_to_bake(work.file.scene, with_directions, per_light, multiple_only);
    require_memory(scene, most_replicates);
    RenderOptions options = watch.options();
    options.photons = IndexRange{0, scene.photons};
    options.measures_matter = true;
    Renderer renderer(scene, *work.backend, options);
    renderer.run();
    result = renderer.result();
    warnings = all_warnings(work, result);
    if (result.photons.count() == 0) {
      throw Error(ExitCode::scene_invalid,
                  name + ": no light reaches the medium: there is nothing to bake");
    }
    light = bake(renderer, scene);
  }
  py::dict fluence, slope;
  for (const BakedGroup& group : light.groups) {
    const std::string key = group.name.empty() ? "all" : group.name;
    fluence[py::str(key)] = cells(light.size, group.fluence);
    if (group.slope[0].empty()) continue;
    py::list axes;
    for (const std::vector<Vec3f>& axis : group.slope) axes.append(cells(light.size, axis));
    slope[py::str(key)] = axes;
  }
  py::dict out;
  out["low"] = py::make_tuple(light.low.x, light.low.y, light.low.z);
  out["high"] = py::make_tuple(light.high.x, light.high.y, light.high.z);
  out["fluence"] = fluence;
  out["slope"] = slope;
  out["albedo"] = cells(light.size, light.albedo);
  out["relative_error"] = py::none();
  if (!light.relative_error.empty())
    out["relative_error"] =
        array({light.size[2], light.size[1], light.size[0]}, light.relative_error.data());
  out["facts"] = facts(result);
  out["warnings"] = warnings;
  return out;
}

std::vector<std::string> validate_text(const std::string& name, const std::string& text,
                                       const std::string& folder,
                                       const std::vector<std::string>& overrides) {
  return io::read_scene_text(name, text, folder, overrides).warnings;
}

}  // namespace
}  // namespace tyndall

PYBIND11_MODULE(_core, m) {
  using namespace tyndall;
  m.attr("version") = TYNDALL_VERSION;
  m.attr("arithmetic") = arithmetic_version;
  // The class itself is the package's, which alone knows it.
  py::register_exception_translator([](std::exception_ptr p) {
    const auto raise = [](const std::string& what, ExitCode code) {
      const py::object type = py::module_::import("tyndall").attr("Error");
      const py::object value = type(what, static_cast<int>(code));
      PyErr_SetObject(type.ptr(), value.ptr());
    };
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Error& error) {
      raise(error.what(), error.code());
    } catch (const Stopped&) {
      PyErr_SetString(PyExc_KeyboardInterrupt, "stopped by the progress callback");
    } catch (const std::bad_alloc&) {
      raise("out of memory; lower camera.resolution or the resolutions of the grids",
            ExitCode::out_of_memory);
    } catch (const py::error_already_set&) {  // of the callback
      throw;
    } catch (const py::builtin_exception&) {
      throw;
    } catch (const std::exception& error) {
      raise(fmt::format("internal error: {}", error.what()), ExitCode::internal);
    }
  });
  m.def("render", &render_text);
  m.def("bake", &bake_text);
  m.def("validate", &validate_text);
  m.def("schema", &io::schema);
  m.def("devices", &session::list_devices);
}
