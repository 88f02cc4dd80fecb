#include "render/gl/gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <stdexcept>

#include "render/gl/context.h"

namespace taut::gl {
namespace {

GlObject compile(const Gl& gl, GLenum kind, const std::string& defines, const char* source) {
  GlObject shader(gl, gl.CreateShader(kind), [](const Gl& g, GLuint id) { g.DeleteShader(id); });
  const std::string head = "#version 450 core\n" + defines;
  const char* parts[] = {head.c_str(), source};
  gl.ShaderSource(shader.id(), 2, parts, nullptr);
  gl.CompileShader(shader.id());
  GLint ok = 0;
  gl.GetShaderiv(shader.id(), GL_COMPILE_STATUS, &ok);
  if (!ok) {
    std::string log(4096, '\0');
    gl.GetShaderInfoLog(shader.id(), GLsizei(log.size()), nullptr, log.data());
    throw std::logic_error(fmt::format("shader: {}", log.c_str()));
  }
  return shader;
}

}  // namespace

GlObject make_buffer(const Gl& gl) {
  GLuint id = 0;
  gl.CreateBuffers(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteBuffers(1, &i); }};
}

GlObject make_vertex_array(const Gl& gl) {
  GLuint id = 0;
  gl.CreateVertexArrays(1, &id);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteVertexArrays(1, &i); }};
}

GlObject make_texture(const Gl& gl, GLenum format, int width, int height, int samples, int levels) {
  GLuint id = 0;
  gl.CreateTextures(samples ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, 1, &id);
  if (samples) {
    gl.TextureStorage2DMultisample(id, samples, format, width, height, GL_TRUE);
  } else {
    gl.TextureStorage2D(id, levels, format, width, height);
    gl.TextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl.TextureParameteri(id, GL_TEXTURE_MIN_FILTER,
                         levels > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  }
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteTextures(1, &i); }};
}

GlObject make_depth_layers(const Gl& gl, GLenum format, int width, int height, int layers) {
  GLuint id = 0;
  gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  gl.TextureStorage3D(id, 1, format, width, height, layers);
  for (const auto& [name, value] : {std::pair(GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE),
                                    {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE},
                                    {GL_TEXTURE_MIN_FILTER, GL_NEAREST},
                                    {GL_TEXTURE_MAG_FILTER, GL_NEAREST}})
    gl.TextureParameteri(id, GLenum(name), value);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteTextures(1, &i); }};
}

GlObject make_depth_sampler(const Gl& gl) {
  GLuint id = 0;
  gl.CreateSamplers(1, &id);
  for (const auto& [name, value] : {std::pair(GL_TEXTURE_COMPARE_MODE, GL_NONE),
                                    {GL_TEXTURE_MIN_FILTER, GL_NEAREST},
                                    {GL_TEXTURE_MAG_FILTER, GL_NEAREST},
                                    {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE},
                                    {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE}})
    gl.SamplerParameteri(id, GLenum(name), value);
  return {gl, id, [](const Gl& g, GLuint i) { g.DeleteSamplers(1, &i); }};
}

namespace {

GlObject make_target(const Gl& gl, GLuint color) {
  GLuint id = 0;
  gl.CreateFramebuffers(1, &id);
  GlObject framebuffer(gl, id, [](const Gl& g, GLuint i) { g.DeleteFramebuffers(1, &i); });
  if (color) {
    gl.NamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color, 0);
  } else {
    gl.NamedFramebufferDrawBuffer(id, GL_NONE);
    gl.NamedFramebufferReadBuffer(id, GL_NONE);
  }
  return framebuffer;
}

GlObject checked(const Gl& gl, GlObject framebuffer) {
  const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer.id(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw render::NoContext(
        fmt::format("the driver cannot draw into this framebuffer ({:#x})", status));
  return framebuffer;
}

}  // namespace

GlObject make_framebuffer(const Gl& gl, GLuint color, GLuint depth) {
  GlObject framebuffer = make_target(gl, color);
  if (depth) gl.NamedFramebufferTexture(framebuffer.id(), GL_DEPTH_ATTACHMENT, depth, 0);
  return checked(gl, std::move(framebuffer));
}

GlObject make_layer_framebuffer(const Gl& gl, GLuint layers, int layer) {
  GlObject framebuffer = make_target(gl, 0);
  gl.NamedFramebufferTextureLayer(framebuffer.id(), GL_DEPTH_ATTACHMENT, layers, 0, layer);
  return checked(gl, std::move(framebuffer));
}

Program::Program(const Gl& gl, const std::string& defines, const char* vertex, const char* fragment)
    : gl_(&gl),
      object_(gl, gl.CreateProgram(), [](const Gl& g, GLuint id) { g.DeleteProgram(id); }) {
  const GlObject shaders[] = {compile(gl, GL_VERTEX_SHADER, defines, vertex),
                              compile(gl, GL_FRAGMENT_SHADER, defines, fragment)};
  for (const GlObject& shader : shaders) gl.AttachShader(object_.id(), shader.id());
  gl.LinkProgram(object_.id());
  GLint ok = 0;
  gl.GetProgramiv(object_.id(), GL_LINK_STATUS, &ok);
  if (!ok) {
    std::string log(4096, '\0');
    gl.GetProgramInfoLog(object_.id(), GLsizei(log.size()), nullptr, log.data());
    throw std::logic_error(fmt::format("shader program: {}", log.c_str()));
  }
}

GLint Program::location(const char* name) const {
  return gl_->GetUniformLocation(object_.id(), name);
}

void Program::set(const char* name, int value) const {
  gl_->ProgramUniform1i(object_.id(), location(name), value);
}
void Program::set(const char* name, int x, int y) const {
  gl_->ProgramUniform2i(object_.id(), location(name), x, y);
}
void Program::set(const char* name, float value) const {
  gl_->ProgramUniform1f(object_.id(), location(name), value);
}
void Program::set(const char* name, const Eigen::Vector3f& value) const {
  gl_->ProgramUniform3fv(object_.id(), location(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Vector4f& value) const {
  gl_->ProgramUniform4fv(object_.id(), location(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& value) const {
  gl_->ProgramUniformMatrix4fv(object_.id(), location(name), 1, GL_FALSE, value.data());
}

namespace {

Profile::Times now() {
  timespec cpu{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  const auto wall = std::chrono::steady_clock::now().time_since_epoch();
  return {double(cpu.tv_sec) + 1e-9 * double(cpu.tv_nsec),
          std::chrono::duration<double>(wall).count()};
}

double median(const std::vector<Profile::Times>& frames, double Profile::Times::*time) {
  std::vector<double> times;
  for (const Profile::Times& frame : frames) times.push_back(frame.*time);
  const auto middle = times.begin() + std::ptrdiff_t(times.size() / 2);
  std::ranges::nth_element(times, middle);
  return times.empty() ? 0 : *middle;
}

}  // namespace

void Profile::start() {
  last_ = now();
}

void Profile::lap(const char* stage) {
  const Times time = now();
  auto found = std::ranges::find(stages_, stage, &Stage::name);
  if (found == stages_.end()) found = stages_.insert(stages_.end(), Stage{stage, {}});
  found->frames.push_back({time.cpu - last_.cpu, time.wall - last_.wall});
  last_ = time;
}

Profile::Times median(const Profile::Stage& stage) {
  return {median(stage.frames, &Profile::Times::cpu), median(stage.frames, &Profile::Times::wall)};
}

}  // namespace taut::gl
