// SPDX-License-Identifier: Apache-2.0
// The Python module multum._multum, which is a thin layer over multum.h. The Python files of the package
// (host/api/python/multum) give it the form that users see.
#include <multum.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace {

// Returns text that may quote file names of any bytes, as Python represents them.
py::object text_of_bytes(const char* text) {
  return py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(text));
}

// Raises the exception of multum._errors that belongs to an error, and frees the error.
[[noreturn]] void raise(multum_error* error, multum_status status) {
  const std::unique_ptr<multum_error, decltype(&multum_error_free)> owned(error, multum_error_free);
  const py::object made =
      py::module_::import("multum._errors")
          .attr("make_error")(static_cast<int>(status), multum_error_message(error), multum_error_file(error),
                              multum_error_found(error), multum_error_expected(error));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
  throw py::error_already_set();
}

template <typename Call>
void check(const Call& call) {
  multum_error* error = nullptr;
  const multum_status status = call(&error);
  if (status != MULTUM_OK) raise(error, status);
}

// Connects Python functions to a long call. The call runs without the lock of the interpreter, and Ctrl-C cancels it.
class Callbacks {
 public:
  Callbacks(py::object progress, py::object log) : progress_(std::move(progress)), log_(std::move(log)) {
    callbacks_.user = this;
    callbacks_.progress = [](void* user, const char* stage, double share) {
      return static_cast<Callbacks*>(user)->hear_progress(stage, share);
    };
    callbacks_.log = [](void* user, multum_log_kind kind, const char* message) {
      static_cast<Callbacks*>(user)->hear_log(kind, message);
    };
  }

  template <typename Call>
  void run(const Call& call) {
    multum_error* error = nullptr;
    multum_status status = MULTUM_OK;
    {
      const py::gil_scoped_release release;
      status = call(&callbacks_, &error);
    }
    if (failure_) {
      multum_error_free(error);
      std::rethrow_exception(std::exchange(failure_, nullptr));
    }
    if (status != MULTUM_OK) raise(error, status);
  }

 private:
  // Keeps a Python exception until the call has ended.
  template <typename Body>
  int hear(const Body& body) {
    const py::gil_scoped_acquire acquire;
    if (failure_) return 1;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      body();
      return 0;
    } catch (...) {
      failure_ = std::current_exception();
      return 1;
    }
  }

  int hear_progress(const char* stage, double share) {
    return hear([&] {
      if (!progress_.is_none()) progress_(text_of_bytes(stage), share);
    });
  }
  void hear_log(multum_log_kind kind, const char* message) {
    hear([&] {
      if (!log_.is_none()) log_(static_cast<int>(kind), text_of_bytes(message));
    });
  }

  multum_callbacks callbacks_ = MULTUM_CALLBACKS_INIT;
  py::object progress_, log_;
  std::exception_ptr failure_;
};

class Device {
 public:
  explicit Device(const std::string& selector) {
    multum_device* device = nullptr;
    check([&](multum_error** error) { return multum_device_open(selector.c_str(), &device, error); });
    device_.reset(device, multum_device_free);
  }
  multum_device* get() const { return device_.get(); }
  std::string name() const { return multum_device_name(get()); }

 private:
  std::shared_ptr<multum_device> device_;
};

// Makes the settings of a command from a dictionary. None means the default.
class Values {
 public:
  Values(const std::string& command, const py::dict& settings) {
    multum_values* made = nullptr;
    check([&](multum_error** error) { return multum_values_new(command.c_str(), &made, error); });
    values_.reset(made, multum_values_free);
    for (const auto& [key, value] : settings)
      set(py::cast<std::string>(key), py::reinterpret_borrow<py::object>(value));
  }
  const multum_values* get() const { return values_.get(); }

 private:
  void set(const std::string& name, const py::object& value) {
    if (value.is_none()) return;
    check([&](multum_error** error) {
      if (py::isinstance<py::bool_>(value))
        return multum_values_set_flag(values_.get(), name.c_str(), py::cast<bool>(value) ? 1 : 0, error);
      if (py::isinstance<py::str>(value))
        return multum_values_set_text(values_.get(), name.c_str(), py::cast<std::string>(value).c_str(), error);
      return multum_values_set_number(values_.get(), name.c_str(), py::cast<double>(value), error);
    });
  }

  std::shared_ptr<multum_values> values_;
};

multum_type type_of(const py::array& array) {
  const py::dtype type = array.dtype();
  if (type.kind() == 'u' && type.itemsize() == 1) return MULTUM_UINT8;
  if (type.kind() == 'u' && type.itemsize() == 2) return MULTUM_UINT16;
  if (type.kind() == 'f' && type.itemsize() == 2) return MULTUM_HALF;
  return MULTUM_FLOAT;
}

// Arrays of shape (height, width, channels) whose pixels are contiguous within a row. The Python code of the package
// ensures the shape and the type.
struct Maps {
  Maps(const std::string& input, const py::dict& images) : file(input) {
    maps.input = file.empty() ? nullptr : file.c_str();
    add(images, "normals", normals, maps.normals);
    add(images, "albedo", albedo, maps.albedo);
    add(images, "roughness", roughness, maps.roughness);
    add(images, "weights", weights, maps.weights);
  }

  void add(const py::dict& images, const char* name, multum_image& image, const multum_image*& place) {
    if (!images.contains(name)) return;
    const py::array array = py::cast<py::array>(images[name]);
    image.width = static_cast<int>(array.shape(1));
    image.height = static_cast<int>(array.shape(0));
    image.channels = static_cast<int>(array.shape(2));
    image.type = type_of(array);
    image.row_bytes = static_cast<std::ptrdiff_t>(array.strides(0));
    image.pixels = array.data();
    place = &image;
    kept.push_back(array);
  }

  std::string file;
  multum_image normals = MULTUM_IMAGE_INIT, albedo = MULTUM_IMAGE_INIT, roughness = MULTUM_IMAGE_INIT,
               weights = MULTUM_IMAGE_INIT;
  multum_maps maps = MULTUM_MAPS_INIT;
  std::vector<py::array> kept;
};

const char* name_or_null(const std::string& name) { return name.empty() ? nullptr : name.c_str(); }

py::dtype dtype_of(multum_type type) {
  if (type == MULTUM_HALF) return py::dtype("float16");
  return type == MULTUM_SNORM16 ? py::dtype("int16") : py::dtype("float32");
}

class Map {
 public:
  explicit Map(multum_map* map) : map_(map, multum_map_free) {}
  explicit Map(std::shared_ptr<multum_map> map) : map_(std::move(map)) {}
  multum_map* get() const { return map_.get(); }

  py::dict info() const {
    const multum_info i = multum_map_info(get());
    using namespace py::literals;
    return py::dict("width"_a = i.width, "height"_a = i.height, "level_count"_a = i.level_count,
                    "first_level"_a = i.first_level, "lobe_count"_a = i.lobe_count, "sh_order"_a = i.sh_order,
                    "has_colours"_a = i.has_colours != 0, "weight_count"_a = i.weight_count,
                    "repeats"_a = py::make_tuple(i.repeats_s != 0, i.repeats_t != 0));
  }
  std::string text(const std::string& key) const { return multum_map_text(get(), key.c_str()); }

  // The array uses the map's memory, and keeps the map alive.
  py::array level(int level, int part) const {
    multum_view view = {};
    {
      multum_error* error = nullptr;
      multum_status status = MULTUM_OK;
      {
        const py::gil_scoped_release release;
        status = multum_map_level(get(), level, static_cast<multum_part>(part), &view, &error);
      }
      if (status != MULTUM_OK) raise(error, status);
    }
    const py::capsule owner(new std::shared_ptr<multum_map>(map_),
                            [](void* p) { delete static_cast<std::shared_ptr<multum_map>*>(p); });
    py::array_t<float> array({view.layers, view.height, view.width, view.channels}, view.values, owner);
    array.attr("flags").attr("writeable") = false;
    return array;
  }

  py::array read(int level, int part, int x, int y, int width, int height, int type) const {
    const multum_view shape = multum_map_shape(get(), level, static_cast<multum_part>(part));
    py::array array(dtype_of(static_cast<multum_type>(type)),
                    std::vector<py::ssize_t>{std::max(shape.layers, 1), std::max(height, 1), std::max(width, 1),
                                             std::max(shape.channels, 1)});
    void* const room = array.mutable_data();
    multum_error* error = nullptr;
    multum_status status = MULTUM_OK;
    {
      const py::gil_scoped_release release;
      status = multum_map_read(get(), level, static_cast<multum_part>(part), {x, y, width, height},
                               static_cast<multum_type>(type), room, &error);
    }
    if (status != MULTUM_OK) raise(error, status);
    return array;
  }

  void save(const std::string& path) const {
    check([&](multum_error** error) { return multum_map_save(get(), path.c_str(), error); });
  }

 private:
  std::shared_ptr<multum_map> map_;
};

class Brdf {
 public:
  explicit Brdf(const std::string& text) {
    multum_brdf* brdf = nullptr;
    check([&](multum_error** error) { return multum_brdf_new(text.c_str(), &brdf, error); });
    brdf_.reset(brdf, multum_brdf_free);
  }
  const multum_brdf* get() const { return brdf_.get(); }

 private:
  std::shared_ptr<multum_brdf> brdf_;
};

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

// The lobes of many points. They are arrays of shape (count, lobes, 4), and of shape (count, lobes, 3), or (0,) if
// there are no colours.
struct LobeRows {
  LobeRows(Floats lobes_in, Floats colours_in, float mean_cosine_in)
      : lobes(std::move(lobes_in)), colours(std::move(colours_in)), mean_cosine(mean_cosine_in) {
    count = lobes.shape(0);
    lobe_count = static_cast<int>(lobes.shape(1));
    if (lobe_count > MULTUM_LOBES_MAX) throw py::value_error("more than 8 lobes per point");
    has_colours = colours.ndim() == 3;
  }
  multum_lobes at(py::ssize_t i) const {
    multum_lobes result = {};
    result.count = lobe_count;
    result.has_colours = has_colours ? 1 : 0;
    result.mean_cosine = mean_cosine;
    const float* const from = lobes.data() + i * lobe_count * 4;
    for (int j = 0; j < lobe_count; ++j)
      for (int c = 0; c < 4; ++c) result.lobes[j][c] = from[4 * j + c];
    if (!has_colours) return result;
    const float* const colour = colours.data() + i * lobe_count * 3;
    for (int j = 0; j < lobe_count; ++j)
      for (int c = 0; c < 3; ++c) result.colours[j][c] = colour[3 * j + c];
    return result;
  }

  Floats lobes, colours;
  float mean_cosine;
  py::ssize_t count;
  int lobe_count;
  bool has_colours;
};

// `places` has the shape (count, 3), with u, v and level of detail. Returns lobes, colours and the mean cosine of the
// roughness that the lobes contain.
py::tuple look_up(const Map& map, const Doubles& places) {
  const multum_info info = multum_map_info(map.get());
  const py::ssize_t count = places.shape(0), lobes = info.lobe_count;
  py::array_t<float> found({count, lobes, py::ssize_t{4}});
  py::array_t<float> colours(info.has_colours != 0 ? std::vector<py::ssize_t>{count, lobes, 3}
                                                   : std::vector<py::ssize_t>{0});
  float* const to = found.mutable_data();
  float* const colours_to = colours.mutable_data();
  const double* const from = places.data();
  float mean_cosine = 0.0f;
  multum_error* error = nullptr;
  multum_status status = MULTUM_OK;
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < count && status == MULTUM_OK; ++i) {
      multum_lobes one;
      status = multum_map_lookup(map.get(), from[3 * i], from[3 * i + 1], from[3 * i + 2], &one, &error);
      if (status != MULTUM_OK) break;
      mean_cosine = one.mean_cosine;
      for (py::ssize_t j = 0; j < lobes; ++j) {
        for (py::ssize_t c = 0; c < 4; ++c) to[(i * lobes + j) * 4 + c] = one.lobes[j][c];
        if (info.has_colours == 0) continue;
        for (py::ssize_t c = 0; c < 3; ++c) colours_to[(i * lobes + j) * 3 + c] = one.colours[j][c];
      }
    }
  }
  if (status != MULTUM_OK) raise(error, status);
  return py::make_tuple(found, colours, mean_cosine);
}

Doubles shade(const LobeRows& rows, const Brdf& brdf, const Doubles& light, const Doubles& view) {
  Doubles rgb({rows.count, py::ssize_t{3}});
  double* const to = rgb.mutable_data();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < rows.count; ++i) {
    const multum_lobes lobes = rows.at(i);
    multum_shade(&lobes, brdf.get(), light.data() + 3 * i, view.data() + 3 * i, to + 3 * i);
  }
  return rgb;
}

Doubles density(const LobeRows& rows, const Doubles& normal) {
  Doubles values(rows.count);
  double* const to = values.mutable_data();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < rows.count; ++i) {
    const multum_lobes lobes = rows.at(i);
    to[i] = multum_density(&lobes, normal.data() + 3 * i);
  }
  return values;
}

py::tuple sample(const LobeRows& rows, const Brdf& brdf, const Doubles& view, const Doubles& random) {
  Doubles light({rows.count, py::ssize_t{3}}), pdf(rows.count);
  double *const to = light.mutable_data(), *const pdf_to = pdf.mutable_data();
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < rows.count; ++i) {
      const multum_lobes lobes = rows.at(i);
      pdf_to[i] = multum_sample(&lobes, brdf.get(), view.data() + 3 * i, random.data() + 3 * i, to + 3 * i);
    }
  }
  return py::make_tuple(light, pdf);
}

Doubles pdf_of(const LobeRows& rows, const Brdf& brdf, const Doubles& view, const Doubles& light) {
  Doubles pdf(rows.count);
  double* const to = pdf.mutable_data();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < rows.count; ++i) {
    const multum_lobes lobes = rows.at(i);
    to[i] = multum_pdf(&lobes, brdf.get(), view.data() + 3 * i, light.data() + 3 * i);
  }
  return pdf;
}

Map bake(const Device& device, const Maps& maps, const Values& values, const std::string& output,
         const py::object& progress, const py::object& log) {
  std::shared_ptr<multum_map> owned;  // freed if a callback has failed although the bake succeeded
  Callbacks(progress, log).run([&](const multum_callbacks* callbacks, multum_error** error) {
    multum_map* map = nullptr;
    const multum_status status =
        multum_bake(device.get(), &maps.maps, values.get(), name_or_null(output), callbacks, &map, error);
    owned.reset(map, multum_map_free);
    return status;
  });
  return Map(std::move(owned));
}

template <typename Call>
std::string text_of(const py::object& progress, const py::object& log, const Call& call) {
  multum_text* text = nullptr;
  Callbacks(progress, log).run([&](const multum_callbacks* callbacks, multum_error** error) {
    return call(callbacks, &text, error);
  });
  const std::unique_ptr<multum_text, decltype(&multum_text_free)> owned(text, multum_text_free);
  return multum_text_get(text);
}

std::string export_map(const Device& device, const Maps& maps, const Values& values, const std::string& output,
                       const py::object& progress, const py::object& log) {
  return text_of(progress, log, [&](const multum_callbacks* callbacks, multum_text** text, multum_error** error) {
    return multum_export(device.get(), &maps.maps, values.get(), output.c_str(), callbacks, text, error);
  });
}

std::string convert_model(const Device& device, const std::string& input, const Values& values,
                          const std::string& output, const py::object& progress, const py::object& log) {
  return text_of(progress, log, [&](const multum_callbacks* callbacks, multum_text** text, multum_error** error) {
    return multum_convert_model(device.get(), input.c_str(), values.get(), output.c_str(), callbacks, text, error);
  });
}

std::string measure(const Device& device, const std::string& baked, const Maps& maps, const Values& values,
                    const py::object& progress, const py::object& log) {
  return text_of(progress, log, [&](const multum_callbacks* callbacks, multum_text** text, multum_error** error) {
    return multum_measure(device.get(), baked.c_str(), &maps.maps, values.get(), callbacks, text, error);
  });
}

py::array_t<float> render_plane(const Device& device, const Map& map, const Brdf& brdf, const Doubles& vectors,
                                double fov, int width, int height, int taps, const py::object& progress,
                                const py::object& log) {
  multum_plane plane = MULTUM_PLANE_INIT;
  for (py::ssize_t c = 0; c < 3; ++c) {
    plane.eye[c] = vectors.at(0, c);
    plane.target[c] = vectors.at(1, c);
    plane.light[c] = vectors.at(2, c);
  }
  plane.fov = fov;
  plane.width = width;
  plane.height = height;
  plane.taps = taps;
  // The library refuses sizes out of range before it writes.
  py::array_t<float> picture({std::clamp(height, 1, 16384), std::clamp(width, 1, 16384), 4});
  float* const rgba = picture.mutable_data();
  Callbacks(progress, log).run([&](const multum_callbacks* callbacks, multum_error** error) {
    return multum_render_plane(device.get(), map.get(), brdf.get(), &plane, callbacks, rgba, error);
  });
  return picture;
}

std::string infer(const Device& device, const std::string& job, const Values& values, const std::string& output,
                  const py::object& progress, const py::object& log) {
  return text_of(progress, log, [&](const multum_callbacks* callbacks, multum_text** text, multum_error** error) {
    return multum_infer(device.get(), job.c_str(), values.get(), output.c_str(), callbacks, text, error);
  });
}

std::string pack(const Device& device, const std::string& folder, const Values& values, const std::string& output,
                 const py::object& progress, const py::object& log) {
  return text_of(progress, log, [&](const multum_callbacks* callbacks, multum_text** text, multum_error** error) {
    return multum_pack(device.get(), folder.c_str(), values.get(), output.c_str(), callbacks, text, error);
  });
}

void publish_field(const std::string& packed, const std::string& output) {
  check([&](multum_error** error) { return multum_publish_field(packed.c_str(), output.c_str(), error); });
}

class Field {
 public:
  explicit Field(const std::string& path) {
    multum_field* field = nullptr;
    check([&](multum_error** error) { return multum_field_open(path.c_str(), &field, error); });
    field_.reset(field, multum_field_free);
  }

  std::string text() const { return multum_field_text(field_.get()); }

  // Returns an array of shape (height, width, 3), or None if the layer is invisible.
  py::object texture(int layer, const Doubles& point) const {
    multum_view shape = {};
    check([&](multum_error** error) {
      return multum_field_texture(field_.get(), layer, point.data(), &shape, nullptr, error);
    });
    if (shape.layers == 0) return py::none();
    py::array_t<float> rgb({shape.height, shape.width, 3});
    float* const to = rgb.mutable_data();
    multum_error* error = nullptr;
    multum_status status = MULTUM_OK;
    {
      const py::gil_scoped_release release;
      status = multum_field_texture(field_.get(), layer, point.data(), &shape, to, &error);
    }
    if (status != MULTUM_OK) raise(error, status);
    return rgb;
  }

  // `points` has the shape (count, parameters). Returns frames of shape (count, height, width, 4).
  py::array_t<float> play(const Doubles& points, int width, int height, bool is_linear, const py::object& progress,
                          const py::object& log) const {
    py::array_t<float> frames({points.shape(0), py::ssize_t{height}, py::ssize_t{width}, py::ssize_t{4}});
    float* const rgba = frames.mutable_data();
    Callbacks(progress, log).run([&](const multum_callbacks* callbacks, multum_error** error) {
      return multum_field_play(field_.get(), points.data(), static_cast<int>(points.shape(0)), is_linear ? 1 : 0,
                               callbacks, rgba, error);
    });
    return frames;
  }

 private:
  std::shared_ptr<multum_field> field_;
};

Map open_map(const std::string& path) {
  multum_map* map = nullptr;
  check([&](multum_error** error) { return multum_map_open(path.c_str(), &map, error); });
  return Map(map);
}

py::list devices() {
  py::list all;
  check([&](multum_error** error) {
    return multum_list_devices(
        [](void* user, int index, const char* name, const char* platform) {
          static_cast<py::list*>(user)->append(py::make_tuple(index, name, platform));
        },
        &all, error);
  });
  return all;
}

py::list parameters(const std::string& command) {
  py::list all;
  for (int i = 0; i < multum_parameter_count(command.c_str()); ++i) {
    const multum_parameter one = multum_parameter_at(command.c_str(), i);
    all.append(py::make_tuple(one.name, one.help, one.values));
  }
  return all;
}

}  // namespace

PYBIND11_MODULE(_multum, module) {
  module.attr("__version__") = multum_version();
  py::class_<Device>(module, "Device").def(py::init<const std::string&>()).def_property_readonly("name", &Device::name);
  py::class_<Values>(module, "Values").def(py::init<const std::string&, const py::dict&>());
  py::class_<Maps>(module, "Maps").def(py::init<const std::string&, const py::dict&>());
  py::class_<Brdf>(module, "Brdf").def(py::init<const std::string&>());
  py::class_<LobeRows>(module, "LobeRows").def(py::init<Floats, Floats, float>());
  py::class_<Map>(module, "Map")
      .def("info", &Map::info)
      .def("text", &Map::text)
      .def("level", &Map::level)
      .def("read", &Map::read)
      .def("save", &Map::save);
  module.def("open_map", &open_map);
  module.def("bake", &bake);
  module.def("export_map", &export_map);
  module.def("convert_model", &convert_model);
  module.def("measure", &measure);
  module.def("look_up", &look_up);
  module.def("shade", &shade);
  module.def("density", &density);
  module.def("sample", &sample);
  module.def("pdf", &pdf_of);
  py::class_<Field>(module, "Field")
      .def(py::init<const std::string&>())
      .def("text", &Field::text)
      .def("texture", &Field::texture)
      .def("play", &Field::play);
  module.def("infer", &infer);
  module.def("pack", &pack);
  module.def("publish_field", &publish_field);
  module.def("render_plane", &render_plane);
  module.def("devices", &devices);
  module.def("parameters", &parameters);
}
