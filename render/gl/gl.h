// The OpenGL functions in use, as a table filled at run time: nothing here links against GL.
#pragma once

#define GL_GLEXT_PROTOTYPES  // for the types of the functions only
#include <GL/glcorearb.h>

namespace taut::gl {

// clang-format off
#define TAUT_GL_FUNCTIONS(X) \
  X(AttachShader) X(BindBufferBase) X(BindFramebuffer) X(BindSampler) X(BindTextureUnit) X(BindVertexArray) \
  X(BlendFunc) X(CheckNamedFramebufferStatus) X(Clear) X(ClearColor) X(CompileShader) X(CopyImageSubData) X(CreateBuffers) \
  X(CreateFramebuffers) X(CreateProgram) X(CreateSamplers) X(CreateShader) X(CreateTextures) X(CreateVertexArrays) X(CullFace) \
  X(DeleteBuffers) X(DeleteFramebuffers) X(DeleteProgram) X(DeleteSamplers) X(DeleteShader) X(DeleteTextures) \
  X(DeleteVertexArrays) X(DepthFunc) X(DepthMask) X(Disable) X(DrawArrays) X(DrawElements) \
  X(Enable) X(EnableVertexArrayAttrib) X(Finish) X(GenerateTextureMipmap) X(GetIntegerv) X(GetMultisamplefv) \
  X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog) X(GetShaderiv) X(GetString) X(GetUniformLocation) \
  X(LinkProgram) X(NamedBufferData) X(NamedFramebufferDrawBuffer) X(NamedFramebufferReadBuffer) \
  X(NamedFramebufferTexture) X(NamedFramebufferTextureLayer) X(PixelStorei) X(PolygonOffset) X(ProgramUniform1f) \
  X(ProgramUniform1i) X(ProgramUniform2i) X(ProgramUniform3fv) X(ProgramUniform4fv) X(ProgramUniformMatrix4fv) \
  X(ReadPixels) X(SampleMaski) X(SamplerParameteri) X(Scissor) X(ShaderSource) X(TextureParameteri) X(TextureStorage2D) \
  X(TextureStorage2DMultisample) X(TextureStorage3D) X(TextureSubImage2D) X(TextureSubImage3D) X(UseProgram) X(VertexArrayAttribBinding) \
  X(VertexArrayAttribFormat) X(VertexArrayElementBuffer) X(VertexArrayVertexBuffer) X(Viewport)
// clang-format on

/// OpenGL of one context; `gl.Clear` is glClear, and so on.
struct Gl {
#define TAUT_GL_MEMBER(name) decltype(&gl##name) name = nullptr;
  TAUT_GL_FUNCTIONS(TAUT_GL_MEMBER)
#undef TAUT_GL_MEMBER
};

}  // namespace taut::gl
