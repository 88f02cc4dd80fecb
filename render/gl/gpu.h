// Owners of OpenGL objects (programs, buffers, textures, framebuffers) and the time that drawing
// takes.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/gl.h"

namespace taut::gl {

/// A GL name that its owner deletes. Movable; the Gl must outlive it.
class GlObject {
 public:
  using Delete = void (*)(const Gl&, GLuint);
  GlObject() = default;
  GlObject(const Gl& gl, GLuint id, Delete remove) : gl_(&gl), id_(id), delete_(remove) {}
  GlObject(GlObject&& other) noexcept { swap(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    swap(other);
    return *this;
  }
  ~GlObject() {
    if (id_) delete_(*gl_, id_);
  }
  GLuint id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }

 private:
  void swap(GlObject& other) {
    std::swap(gl_, other.gl_);
    std::swap(id_, other.id_);
    std::swap(delete_, other.delete_);
  }
  const Gl* gl_ = nullptr;
  GLuint id_ = 0;
  Delete delete_ = nullptr;
};

GlObject make_buffer(const Gl& gl);
GlObject make_vertex_array(const Gl& gl);
/// A texture with immutable storage; `samples` 0: an ordinary one with `levels` mipmaps, clamped to
/// its edge, linearly filtered.
GlObject make_texture(const Gl& gl, GLenum format, int width, int height, int samples = 0,
                      int levels = 1);
/// Pictures of depths, one over the other, looked up by the nearest.
GlObject make_depth_layers(const Gl& gl, GLenum format, int width, int height, int layers);
/// How the depths of a texture for comparisons are looked up without one.
GlObject make_depth_sampler(const Gl& gl);
/// A framebuffer of one colour and one depth texture (either may be 0). Throws NoContext where the
/// driver cannot draw into it.
GlObject make_framebuffer(const Gl& gl, GLuint color, GLuint depth);

/// One of a depth of layers.
GlObject make_layer_framebuffer(const Gl& gl, GLuint layers, int layer);

/// Replaces a buffer's contents.
template <typename T>
void upload(const Gl& gl, const GlObject& buffer, std::span<const T> data, GLenum usage) {
  gl.NamedBufferData(buffer.id(), GLsizeiptr(data.size_bytes()), data.data(), usage);
}

/// A vertex and a fragment shader.
class Program {
 public:
  /// `defines` is put before both sources. Throws std::logic_error with the driver's log.
  Program(const Gl& gl, const std::string& defines, const char* vertex, const char* fragment);

  void use() const { gl_->UseProgram(object_.id()); }
  void set(const char* name, int value) const;
  void set(const char* name, int x, int y) const;
  void set(const char* name, float value) const;
  void set(const char* name, const Eigen::Vector3f& value) const;
  void set(const char* name, const Eigen::Vector4f& value) const;
  void set(const char* name, const Eigen::Matrix4f& value) const;

 private:
  GLint location(const char* name) const;
  const Gl* gl_;
  GlObject object_;
};

// Where a frame's time goes.

/// CPU and wall times of the stages that frames go through, one after another.
class Profile {
 public:
  /// Times of one frame, s. CPU time is that of all threads.
  struct Times {
    double cpu = 0, wall = 0;
  };
  struct Stage {
    std::string name;
    std::vector<Times> frames;
  };

  /// Begins to measure: the time since the last lap is nobody's.
  void start();
  /// Ends a stage: the time since `start` or the last lap is its time in one more frame.
  void lap(const char* stage);

  const std::vector<Stage>& stages() const { return stages_; }

 private:
  std::vector<Stage> stages_;
  Times last_;
};

/// The median over frames, of CPU and wall time each on its own.
Profile::Times median(const Profile::Stage& stage);

}  // namespace taut::gl
