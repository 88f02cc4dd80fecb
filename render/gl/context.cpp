#include "render/gl/context.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <utility>
#include <vector>

#define EGL_NO_X11
#define EGL_EGLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>

namespace taut::gl {
namespace {

using GetProcAddress = void (*(*)(const char*))();

/// A shared library opened at run time; it stays open, as drivers do not unload cleanly.
class Library {
 public:
  explicit Library(const char* file) : file_(file), handle_(dlopen(file, RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) throw render::NoContext(dlerror());
  }
  template <typename Function>
  Function function(const char* name) const {
    void* address = dlsym(handle_, name);
    if (!address) throw render::NoContext(fmt::format("{} has no {}", file_, name));
    return reinterpret_cast<Function>(address);
  }

 private:
  const char* file_;
  void* handle_;
};

constexpr int kMajor = 4, kMinor = 5;

}  // namespace

class Context::Platform {
 public:
  virtual ~Platform() = default;
  virtual GetProcAddress get_proc_address() const = 0;
  std::string name;
};

namespace {

#define TAUT_EGL(name) library_.function<decltype(&name)>(#name)

/// EGL without any surface: Mesa's surfaceless platform, or the first device that gives a context.
class EglPlatform : public Context::Platform {
 public:
  explicit EglPlatform(bool device) : get_proc_address_(TAUT_EGL(eglGetProcAddress)) {
    this->name = device ? "EGL device" : "EGL surfaceless";
    const auto displays = device ? device_displays() : surfaceless_display();
    std::string why = "no display";
    for (EGLDisplay display : displays)
      if (open(display, why)) return;
    throw render::NoContext(why);
  }

  ~EglPlatform() override {
    TAUT_EGL(eglMakeCurrent)(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    TAUT_EGL(eglDestroyContext)(display_, context_);
    TAUT_EGL(eglTerminate)(display_);
  }

  GetProcAddress get_proc_address() const override { return get_proc_address_; }

 private:
  template <typename Function>
  Function extension(const char* function) const {
    const auto address = reinterpret_cast<Function>(get_proc_address_(function));
    if (!address) throw render::NoContext(fmt::format("EGL has no {}", function));
    return address;
  }

  EGLDisplay platform_display(EGLenum platform, void* native) const {
    return extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT")(platform, native,
                                                                                  nullptr);
  }

  std::vector<EGLDisplay> surfaceless_display() const {
    return {platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY)};
  }

  std::vector<EGLDisplay> device_displays() const {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT")(EGLint(devices.size()),
                                                               devices.data(), &count);
    std::vector<EGLDisplay> displays;
    for (EGLint i = 0; i < count; ++i)
      displays.push_back(platform_display(EGL_PLATFORM_DEVICE_EXT, devices[std::size_t(i)]));
    return displays;
  }

  bool open(EGLDisplay display, std::string& why) {
    const auto failed = [&](const char* call) {
      why = fmt::format("{} failed with EGL error {:#x}", call, TAUT_EGL(eglGetError)());
      return false;
    };
    if (display == EGL_NO_DISPLAY) return failed("eglGetPlatformDisplayEXT");
    if (!TAUT_EGL(eglInitialize)(display, nullptr, nullptr)) return failed("eglInitialize");
    const auto abandon = [&](const char* call) {
      failed(call);
      TAUT_EGL(eglTerminate)(display);
      return false;
    };
    if (!TAUT_EGL(eglBindAPI)(EGL_OPENGL_API)) return abandon("eglBindAPI");
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 kMajor,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 kMinor,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    const EGLContext context =
        TAUT_EGL(eglCreateContext)(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT) return abandon("eglCreateContext");
    if (!TAUT_EGL(eglMakeCurrent)(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
      failed("eglMakeCurrent");
      TAUT_EGL(eglDestroyContext)(display, context);
      TAUT_EGL(eglTerminate)(display);
      return false;
    }
    display_ = display;
    context_ = context;
    return true;
  }

  Library library_{"libEGL.so.1"};
  GetProcAddress get_proc_address_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

#undef TAUT_EGL

/// OSMesa, the software rasteriser behind its own interface. Its development header has left
/// distributions, so the four functions and the attributes in use are declared here.
class OsmesaPlatform : public Context::Platform {
 public:
  OsmesaPlatform()
      : destroy_(library_.function<Destroy>("OSMesaDestroyContext")),
        get_proc_address_(library_.function<GetProcAddress>("OSMesaGetProcAddress")) {
    name = "OSMesa";
    constexpr int format = 0x22, profile = 0x33, core = 0x34, major = 0x36, minor = 0x37;
    const int attributes[] = {format, GL_RGBA, profile, core, major, kMajor, minor, kMinor, 0, 0};
    context_ = library_.function<Create>("OSMesaCreateContextAttribs")(attributes, nullptr);
    if (!context_)
      throw render::NoContext(
          fmt::format("OSMesa gives no OpenGL {}.{} core context", kMajor, kMinor));
    // OSMesa insists on a window; pictures are drawn into framebuffers of ours.
    if (!library_.function<MakeCurrent>("OSMesaMakeCurrent")(context_, window_.data(),
                                                             GL_UNSIGNED_BYTE, kSide, kSide)) {
      destroy_(context_);
      throw render::NoContext("OSMesaMakeCurrent failed");
    }
  }

  ~OsmesaPlatform() override { destroy_(context_); }

  GetProcAddress get_proc_address() const override { return get_proc_address_; }

 private:
  using Create = void* (*)(const int*, void*);
  using MakeCurrent = unsigned char (*)(void*, void*, GLenum, GLsizei, GLsizei);
  using Destroy = void (*)(void*);
  static constexpr int kSide = 16;

  Library library_{"libOSMesa.so.8"};
  Destroy destroy_;
  GetProcAddress get_proc_address_;
  void* context_ = nullptr;
  std::vector<unsigned char> window_ = std::vector<unsigned char>(kSide * kSide * 4);
};

Gl load_functions(GetProcAddress get) {
  Gl gl;
#define TAUT_GL_LOAD(name)                                        \
  gl.name = reinterpret_cast<decltype(gl.name)>(get("gl" #name)); \
  if (!gl.name) throw render::NoContext("the driver has no gl" #name);
  TAUT_GL_FUNCTIONS(TAUT_GL_LOAD)
#undef TAUT_GL_LOAD
  return gl;
}

}  // namespace

Backend backend_named(const std::string& name) {
  if (name == "auto") return Backend::automatic;
  if (name == "egl") return Backend::egl;
  if (name == "osmesa") return Backend::osmesa;
  throw std::invalid_argument(
      fmt::format("unknown backend '{}' (expected auto, egl or osmesa)", name));
}

Context::Context(Backend backend, int threads, EglDisplay display) {
  // To llvmpipe, 0 means none of its own.
  if (threads > 0) setenv("LP_NUM_THREADS", std::to_string(threads > 1 ? threads : 0).c_str(), 1);
  using Way = std::pair<const char*, std::function<std::unique_ptr<Platform>()>>;
  std::vector<Way> ways;
  if (backend != Backend::osmesa && display != EglDisplay::device)
    ways.emplace_back("EGL surfaceless", [] { return std::make_unique<EglPlatform>(false); });
  if (backend != Backend::osmesa && display != EglDisplay::surfaceless)
    ways.emplace_back("EGL device", [] { return std::make_unique<EglPlatform>(true); });
  if (backend != Backend::egl && display == EglDisplay::any)
    ways.emplace_back("OSMesa", [] { return std::make_unique<OsmesaPlatform>(); });

  std::string tried;
  for (const auto& [way, make] : ways) {
    try {
      platform_ = make();
      gl_ = load_functions(platform_->get_proc_address());
      break;
    } catch (const render::NoContext& e) {
      platform_.reset();
      tried += fmt::format("\n  {}: {}", way, e.what());
    }
  }
  if (!platform_)
    throw render::NoContext(
        fmt::format("no OpenGL {}.{} core context can be opened; tried{}", kMajor, kMinor, tried));

  const auto text = [&](GLenum what) {
    return std::string(reinterpret_cast<const char*>(gl_.GetString(what)));
  };
  way_ = platform_->name;
  driver_ = fmt::format("{}, OpenGL {}", text(GL_RENDERER), text(GL_VERSION));
  GLint texture = 0, samples = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  gl_.GetIntegerv(GL_MAX_COLOR_TEXTURE_SAMPLES, &samples);
  max_size_ = texture;
  max_samples_ = std::max(samples, 1);
}

Context::~Context() = default;

bool Context::is_software() const {
  return driver_.starts_with("llvmpipe") || driver_.starts_with("softpipe");
}

}  // namespace taut::gl
