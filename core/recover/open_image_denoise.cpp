#include "core/recover/open_image_denoise.h"

#include <dlfcn.h>

#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>

#include "core/recover/network.h"

namespace qray {
namespace {

// What of the library's interface is used (its documentation: "Open Image Denoise API", version 2).
using Handle = void*;
constexpr int kCpu = 1, kFloat3 = 3, kBestQuality = 6;
struct Functions {
  Handle (*new_device)(int type);
  void (*set_device_int)(Handle, const char* name, int);
  void (*commit_device)(Handle);
  int (*get_device_error)(Handle, const char** message);
  void (*release_device)(Handle);
  Handle (*new_filter)(Handle device, const char* type);
  void (*set_image)(Handle, const char* name, void* pixels, int format, size_t width, size_t height,
                    size_t offset, size_t pixel_stride, size_t row_stride);
  void (*set_int)(Handle, const char* name, int);
  void (*set_bool)(Handle, const char* name, bool);
  void (*commit_filter)(Handle);
  void (*execute_filter)(Handle);
  void (*release_filter)(Handle);
};

// The first of the functions that the library lacks; none: it has all.
const char* find_functions(Handle library, Functions& out) {
  const char* missing = nullptr;
  const auto find = [&](auto& function, const char* name) {
    void* at = dlsym(library, name);
    if (!at) missing = name;
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(at);
  };
  find(out.new_device, "oidnNewDevice");
  find(out.set_device_int, "oidnSetDeviceInt");
  find(out.commit_device, "oidnCommitDevice");
  find(out.get_device_error, "oidnGetDeviceError");
  find(out.release_device, "oidnReleaseDevice");
  find(out.new_filter, "oidnNewFilter");
  find(out.set_image, "oidnSetSharedFilterImage");
  find(out.set_int, "oidnSetFilterInt");
  find(out.set_bool, "oidnSetFilterBool");
  find(out.commit_filter, "oidnCommitFilter");
  find(out.execute_filter, "oidnExecuteFilter");
  find(out.release_filter, "oidnReleaseFilter");
  return missing;
}

Image three_channels(const Image& image, int first) {
  Image out(image.width(), image.height(), 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = image.at(x, y, first + c);
  return out;
}

class Library final : public OpenImageDenoise {
 public:
  Library(Handle library, const Functions& functions) : library_(library), do_(functions) {}
  ~Library() override { dlclose(library_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  Result<Image> denoise(const Image& features, const Image& colour, int threads) const override {
    const Handle device = do_.new_device(kCpu);
    if (!device) return failed("no device for the processor");
    do_.set_device_int(device, "numThreads", threads);
    do_.commit_device(device);
    Image albedo = three_channels(features, 0), normal = three_channels(features, kFeatureNormal);
    Image input = colour, out(colour.width(), colour.height(), 3);
    filter(device, {{"albedo", &albedo}, {"output", &albedo}}, false);
    filter(device, {{"normal", &normal}, {"output", &normal}}, false);
    filter(device, {{"color", &input}, {"albedo", &albedo}, {"normal", &normal}, {"output", &out}},
           true);
    const char* message = nullptr;
    const bool wrong = do_.get_device_error(device, &message) != 0;
    const std::string what = wrong && message ? message : "an unknown error";
    do_.release_device(device);
    if (wrong) return failed(what);
    return out;
  }

 private:
  static Error failed(const std::string& what) {
    return {ErrorCode::kUnsupported, "Open Image Denoise: " + what, "/recover"};
  }

  void filter(Handle device, std::initializer_list<std::pair<const char*, Image*>> images,
              bool of_colour) const {
    const Handle filter = do_.new_filter(device, "RT");
    if (!filter) return;  // the device keeps the error
    for (const auto& [name, image] : images)
      do_.set_image(filter, name, image->data().data(), kFloat3,
                    static_cast<size_t>(image->width()), static_cast<size_t>(image->height()), 0, 0,
                    0);
    do_.set_int(filter, "quality", kBestQuality);
    if (of_colour) {
      do_.set_bool(filter, "hdr", true);
      do_.set_bool(filter, "cleanAux", true);
    }
    do_.commit_filter(filter);
    do_.execute_filter(filter);
    do_.release_filter(filter);
  }

  Handle library_;
  Functions do_;
};

}  // namespace

Result<std::shared_ptr<const OpenImageDenoise>> OpenImageDenoise::open() {
  const auto unavailable = [](const std::string& what) {
    return Error{ErrorCode::kUnsupported, what, "libOpenImageDenoise.so.2"};
  };
  Handle library = dlopen("libOpenImageDenoise.so.2", RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return unavailable("expected the library of Open Image Denoise, version 2, for 'oidn'");
  Functions functions{};
  if (const char* missing = find_functions(library, functions)) {
    dlclose(library);
    return unavailable("expected version 2 of Open Image Denoise, which has " +
                       std::string(missing));
  }
  return std::shared_ptr<const OpenImageDenoise>(std::make_shared<Library>(library, functions));
}

}  // namespace qray
