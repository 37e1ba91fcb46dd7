// tyndall._core: the extension module of the Python package. It exchanges arrays and dictionaries.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/scene_json.h"
#include "session/devices.h"
#include "session/session.h"
#include "tyndall/render/bake.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

namespace py = pybind11;

/// (pass, fraction of the pass that is done); false stops the work.
using Callback = std::function<bool(const std::string&, double)>;

/// A run that calls back periodically and that Ctrl-C ends. Used without the interpreter's lock.
class Watched {
 public:
  Watched(const std::string& device, int threads, Callback callback)
      : session({threads, device, "none"}), callback_(std::move(callback)) {
    session.on_warning = [this](const std::string& warning) { warnings.push_back(warning); };
    session::RunControl& control = session.control();
    control.show = [this](const Progress& progress) { show(progress); };
    control.is_interrupted = [this] { return is_stopped_.load(); };
    control.keeps_result = false;
  }

  session::Session session;
  std::vector<std::string> warnings;  ///< as on the command line

 private:
  void show(const Progress& progress) {
    const auto now = std::chrono::steady_clock::now();
    const bool is_end = progress.done == progress.total;
    if (!is_end && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    const double fraction = progress.total > 0 ? static_cast<double>(progress.done)
                                                     / static_cast<double>(progress.total)
                                               : 1.0;
    if (callback_ && !callback_(progress.pass, fraction)) is_stopped_ = true;
  }

  const Callback callback_;
  std::chrono::steady_clock::time_point last_{};
  std::atomic<bool> is_stopped_ = false;
};

/// \return a str, as Python names files: bytes that are not UTF-8 become lone surrogates.
py::object text(const std::string& bytes) {
  PyObject* made =
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape");
  if (made == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::object>(made);
}

py::list texts(const std::vector<std::string>& all) {
  py::list out;
  for (const std::string& one : all) out.append(text(one));
  return out;
}

/// \return make(). Turns Python's MemoryError into std::bad_alloc, which is reported as an Error.
template <class F>
auto made(const F& make) {
  try {
    return make();
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_MemoryError)) throw;
    throw std::bad_alloc();
  }
}

py::array_t<float> array(std::vector<py::ssize_t> shape, const float* values) {
  return py::array_t<float>(std::move(shape), values);
}

py::array_t<float> cells(const std::array<int, 3>& size, const std::vector<Vec3f>& colors) {
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  return array({size[2], size[1], size[0], 3}, &colors.data()->x);
}

py::dict facts(const RenderResult& result) {
  py::dict out;
  for (const auto& [key, value] : result.picture.provenance) out[text(key)] = text(value);
  return out;
}

py::dict render_text(const std::string& name, const std::string& scene, const std::string& folder,
                     const std::vector<std::string>& overrides, const std::string& device,
                     int threads, Callback progress) {
  RenderResult result;
  std::vector<std::string> warnings;
  {
    const py::gil_scoped_release no_lock;
    const io::SceneFile file = io::read_scene_text(name, scene, folder, overrides);
    Watched run(device, threads, std::move(progress));
    run.session.accept(file, {});
    run.session.prepare(file.scene);
    const std::unique_ptr<Renderer> renderer =
        run.session.begin(file.scene, run.session.control().options());
    run.session.run(*renderer, false);
    result = renderer->result();
    run.session.finish(result, file.scene);
    warnings = std::move(run.warnings);
  }
  return made([&] {
    const Picture& picture = result.picture;
    py::dict layers;
    for (const PictureLayer& layer : picture.layers)
      layers[text(layer.name)] =
          array({picture.height, picture.width, static_cast<py::ssize_t>(layer.channels.size())},
                layer.values.data());
    py::dict out;
    out["picture"] = array({picture.height, picture.width, 4}, picture.rgba.data());
    out["layers"] = layers;
    out["tallies"] = fmt::format("{:016x}", result.hashes.tallies);
    out["pixels"] = fmt::format("{:016x}", result.hashes.pixels);
    out["facts"] = facts(result);
    out["warnings"] = texts(warnings);
    return out;
  });
}

py::dict bake_text(const std::string& name, const std::string& scene, const std::string& folder,
                   const std::vector<std::string>& overrides, const std::string& device,
                   int threads, Callback progress, bool with_directions, bool per_light,
                   bool multiple_only) {
  BakedLight light;
  RenderResult result;
  std::vector<std::string> warnings;
  {
    const py::gil_scoped_release no_lock;
    io::SceneFile file = io::read_scene_text(name, scene, folder, overrides);
    Watched run(device, threads, std::move(progress));
    const ResolvedScene baked =
        scene_to_bake(file.scene, with_directions, per_light, multiple_only);
    file.warnings = file.warnings_of(baked);
    run.session.accept(file, {});
    run.session.prepare(baked, most_replicates);
    RenderOptions options = run.session.control().options();
    options.photons = IndexRange{0, baked->photons};
    options.measures_matter = true;
    const std::unique_ptr<Renderer> renderer = run.session.begin(baked, options);
    run.session.run(*renderer, false);
    result = renderer->result();
    run.session.finish(result, baked);
    warnings = std::move(run.warnings);
    if (result.photons.count() == 0) {
      throw Error(ExitCode::scene_invalid,
                  name + ": no light reaches the medium: there is nothing to bake");
    }
    light = bake(*renderer, baked);
  }
  return made([&] {
    py::dict fluence, slope;
    for (const BakedGroup& group : light.groups) {
      const std::string key = group.name.empty() ? "all" : group.name;
      fluence[text(key)] = cells(light.size, group.fluence);
      if (group.slope[0].empty()) continue;
      py::list axes;
      for (const std::vector<Vec3f>& axis : group.slope) axes.append(cells(light.size, axis));
      slope[text(key)] = axes;
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
    out["warnings"] = texts(warnings);
    return out;
  });
}

py::list validate_text(const std::string& name, const std::string& scene, const std::string& folder,
                       const std::vector<std::string>& overrides) {
  return made([&] { return texts(io::read_scene_text(name, scene, folder, overrides).warnings); });
}

}  // namespace
}  // namespace tyndall

PYBIND11_MODULE(_core, m) {
  using namespace tyndall;
  m.attr("version") = TYNDALL_VERSION;
  m.attr("arithmetic") = arithmetic_version;
  // The package defines the class of the exceptions, tyndall.Error.
  py::register_exception_translator([](std::exception_ptr p) {
    const auto raise = [](const std::string& what, ExitCode code) {
      const py::object type = py::module_::import("tyndall").attr("Error");
      const py::object value = type(text(what), static_cast<int>(code));
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
