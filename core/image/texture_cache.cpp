#include "core/image/texture_cache.h"

#include <OpenImageIO/texture.h>

#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "core/image/tonemap.h"

namespace qray {
namespace {

OIIO::TextureOpt::Wrap oiio_wrap(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::kClamp:
      return OIIO::TextureOpt::WrapClamp;
    case TextureWrap::kMirror:
      return OIIO::TextureOpt::WrapMirror;
    case TextureWrap::kRepeat:
      break;
  }
  return OIIO::TextureOpt::WrapPeriodic;
}

struct DestroySystem {
  void operator()(OIIO::TextureSystem* system) const { OIIO::TextureSystem::destroy(system, true); }
};

// No fraction is left beyond; also stops NaN.
bool is_near(Vec2 uv) {
  constexpr float kFarthest = 0x1p24f;
  return std::abs(uv.x) < kFarthest && std::abs(uv.y) < kFarthest;
}

struct Entry {
  OIIO::TextureSystem::TextureHandle* file;
  OIIO::TextureOpt options;
  bool srgb;
  int alpha_channel;  // -1: none
  Vec2 texel;
};

}  // namespace

struct TextureCache::Impl {
  std::unique_ptr<OIIO::TextureSystem, DestroySystem> system{
      OIIO::TextureSystem::create(/*shared=*/false)};
  std::vector<Entry> entries;
  const uint64_t id = ++last_id;

  ~Impl() {
    for (const auto& [thread, info] : thread_infos) system->destroy_thread_info(info);
  }

  // The calling thread's. The system's own would outlive it in threads that go on, and a later
  // system at the same address would read the pictures of this one.
  OIIO::TextureSystem::Perthread* thread_info() const {
    thread_local uint64_t owner = 0;
    thread_local OIIO::TextureSystem::Perthread* info = nullptr;
    if (owner != id) {
      const std::lock_guard lock(mutex);
      OIIO::TextureSystem::Perthread*& known = thread_infos[std::this_thread::get_id()];
      if (!known) known = system->create_thread_info();
      info = known;
      owner = id;
    }
    return info;
  }

  // Clears the error of the system on failure.
  bool read(const Entry& entry, Vec2 uv, float* rgb) const {
    OIIO::TextureOpt options = entry.options;  // the system writes to it
    return system->texture(entry.file, thread_info(), options, uv.x, uv.y, 0, 0, 0, 0, 3, rgb);
  }

 private:
  static inline std::atomic<uint64_t> last_id = 0;
  mutable std::mutex mutex;
  mutable std::map<std::thread::id, OIIO::TextureSystem::Perthread*> thread_infos;
};

TextureCache::TextureCache(int max_memory_mb) : impl_(std::make_unique<Impl>()) {
  OIIO::TextureSystem& system = *impl_->system;
  system.attribute("max_memory_MB", static_cast<float>(max_memory_mb));
  system.attribute("autotile", 64);  // so that a scanline file is not kept whole
  system.attribute("automip", 0);
  system.attribute("gray_to_rgb", 1);
  system.attribute("unassociatedalpha", 1);
  system.attribute("flip_t", 1);
}

TextureCache::~TextureCache() = default;

Result<int> TextureCache::open(const std::filesystem::path& path, bool srgb, TextureWrap wrap) {
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec)) {
    return Error{ErrorCode::kNotFound, "no such texture file", path.string()};
  }
  Entry entry{nullptr, {}, srgb, -1, {}};
  entry.options.swrap = entry.options.twrap = oiio_wrap(wrap);
  entry.options.mipmode = OIIO::TextureOpt::MipModeNoMIP;
  entry.options.interpmode = OIIO::TextureOpt::InterpBilinear;
  try {
    entry.file = impl_->system->get_texture_handle(OIIO::ustring(path.string()));
    float rgb[3];
    if (entry.file == nullptr || !impl_->system->good(entry.file) ||
        !impl_->read(entry, {0.5f, 0.5f}, rgb)) {
      return Error{ErrorCode::kInvalid, "expected a picture: " + impl_->system->geterror(),
                   path.string()};
    }
    if (const OIIO::ImageSpec* spec = impl_->system->imagespec(entry.file)) {
      entry.alpha_channel = spec->alpha_channel;
      entry.texel = {1 / static_cast<float>(spec->width), 1 / static_cast<float>(spec->height)};
    }
  } catch (const std::exception& e) {
    return Error{ErrorCode::kInvalid, std::string("expected a picture: ") + e.what(),
                 path.string()};
  }
  impl_->entries.push_back(entry);
  return static_cast<int>(impl_->entries.size()) - 1;
}

Rgb TextureCache::lookup(int handle, Vec2 uv) const {
  const Entry& entry = impl_->entries[static_cast<size_t>(handle)];
  if (!is_near(uv)) return {};
  float rgb[3] = {0, 0, 0};
  if (!impl_->read(entry, uv, rgb)) {
    impl_->system->geterror();  // or the messages of a lost file pile up
    return {};
  }
  const Rgb value{rgb[0], rgb[1], rgb[2]};
  return entry.srgb ? srgb_to_linear(value) : value;
}

float TextureCache::lookup_alpha(int handle, Vec2 uv) const {
  const Entry& entry = impl_->entries[static_cast<size_t>(handle)];
  if (entry.alpha_channel < 0) return 1;
  if (!is_near(uv)) return 0;
  OIIO::TextureOpt options = entry.options;
  options.firstchannel = entry.alpha_channel;
  float alpha = 0;
  if (!impl_->system->texture(entry.file, impl_->thread_info(), options, uv.x, uv.y, 0, 0, 0, 0, 1,
                              &alpha))
    impl_->system->geterror();
  return alpha;
}

Vec2 TextureCache::texel(int handle) const {
  return impl_->entries[static_cast<size_t>(handle)].texel;
}

}  // namespace qray
