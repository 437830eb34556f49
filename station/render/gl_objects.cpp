#include "station/render/gl_objects.h"

#include <cstddef>
#include <glm/gtc/type_ptr.hpp>
#include <stdexcept>
#include <utility>

#include "common/base/check.h"

namespace enamel::station::render {
namespace {

GLuint Compile(GLenum kind, std::initializer_list<const char*> source) {
  GLuint shader = glCreateShader(kind);
  glShaderSource(shader, static_cast<GLsizei>(source.size()), source.begin(), nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  char log[2048] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glDeleteShader(shader);
  throw std::runtime_error(std::string("the graphics driver refused a shader: ") + log);
}

GLuint MakeTexture(GLenum format, int width, int height, GLenum filter) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D, name);
  bool depth = format == GL_DEPTH_COMPONENT24;
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0,
               depth ? GL_DEPTH_COMPONENT : GL_RGBA, depth ? GL_UNSIGNED_INT : GL_UNSIGNED_BYTE,
               nullptr);
  // The mean of two depths would be a depth with nothing there.
  auto sampling = static_cast<GLint>(depth ? GL_NEAREST : filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, sampling);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, sampling);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return name;
}

}  // namespace

Program::Program(std::initializer_list<const char*> vertex_source,
                 std::initializer_list<const char*> fragment_source) {
  GLuint vertex = Compile(GL_VERTEX_SHADER, vertex_source);
  GLuint fragment = Compile(GL_FRAGMENT_SHADER, fragment_source);
  name_ = glCreateProgram();
  glAttachShader(name_, vertex);
  glAttachShader(name_, fragment);
  glLinkProgram(name_);
  // The linked program keeps its copy.
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint ok = 0;
  glGetProgramiv(name_, GL_LINK_STATUS, &ok);
  if (ok) return;
  char log[2048] = "";
  glGetProgramInfoLog(name_, sizeof log, nullptr, log);
  glDeleteProgram(name_);
  throw std::runtime_error(std::string("the graphics driver could not link a shader: ") + log);
}

void Program::Set(const char* uniform, const glm::mat4& m) const {
  glUniformMatrix4fv(Location(uniform), 1, GL_FALSE, glm::value_ptr(m));
}
void Program::Set(const char* uniform, const glm::vec3& v) const {
  glUniform3f(Location(uniform), v.x, v.y, v.z);
}
void Program::Set(const char* uniform, const glm::vec4& v) const {
  glUniform4f(Location(uniform), v.x, v.y, v.z, v.w);
}
void Program::Set(const char* uniform, float v) const { glUniform1f(Location(uniform), v); }
void Program::Set(const char* uniform, int v) const { glUniform1i(Location(uniform), v); }
void Program::Set(const char* uniform, std::span<const glm::vec3> v) const {
  glUniform3fv(Location(uniform), static_cast<GLsizei>(v.size()), &v[0].x);
}
void Program::Set(const char* uniform, std::span<const float> v) const {
  glUniform1fv(Location(uniform), static_cast<GLsizei>(v.size()), v.data());
}

TriangleBuffer::TriangleBuffer() {
  glGenVertexArrays(1, &array_);
  glGenBuffers(1, &vertices_);
  glGenBuffers(1, &indices_);
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  auto at = [](size_t offset) { return reinterpret_cast<const void*>(offset); };
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(GpuVertex),
                        at(offsetof(GpuVertex, position_mm)));
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 3, GL_BYTE, GL_TRUE, sizeof(GpuVertex), at(offsetof(GpuVertex, normal)));
  glEnableVertexAttribArray(2);
  glVertexAttribIPointer(2, 1, GL_UNSIGNED_BYTE, sizeof(GpuVertex),
                         at(offsetof(GpuVertex, tissue)));
  glEnableVertexAttribArray(3);
  glVertexAttribPointer(3, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(GpuVertex),
                        at(offsetof(GpuVertex, look)));
  glBindVertexArray(0);
}

TriangleBuffer::TriangleBuffer(TriangleBuffer&& other) noexcept
    // OpenGL ignores the name 0 on deletion: a moved-from object owns nothing.
    : array_(std::exchange(other.array_, 0)),
      vertices_(std::exchange(other.vertices_, 0)),
      indices_(std::exchange(other.indices_, 0)),
      count_(std::exchange(other.count_, 0)),
      coarse_count_(std::exchange(other.coarse_count_, 0)) {}

TriangleBuffer::~TriangleBuffer() {
  glDeleteVertexArrays(1, &array_);
  glDeleteBuffers(1, &vertices_);
  glDeleteBuffers(1, &indices_);
}

void TriangleBuffer::Upload(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices,
                            std::span<const uint32_t> coarse) {
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
               GL_DYNAMIC_DRAW);
  auto size = static_cast<GLsizeiptr>(indices.size_bytes()),
       coarse_size = static_cast<GLsizeiptr>(coarse.size_bytes());
  // Both kinds of triangles in one buffer, the coarse ones last: one array object draws either.
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, size + coarse_size, nullptr, GL_DYNAMIC_DRAW);
  glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, size, indices.data());
  glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, size, coarse_size, coarse.data());
  glBindVertexArray(0);
  count_ = static_cast<GLsizei>(indices.size());
  coarse_count_ = static_cast<GLsizei>(coarse.size());
}

size_t TriangleBuffer::Draw(bool coarse) const {
  bool coarser = coarse && coarse_count_ > 0;
  GLsizei count = coarser ? coarse_count_ : count_;
  if (count == 0) return 0;
  size_t first = coarser ? static_cast<size_t>(count_) * sizeof(uint32_t) : 0;
  glBindVertexArray(array_);
  glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(first));
  return static_cast<size_t>(count) / 3;
}

Target::Target(int width, int height, std::initializer_list<GLenum> colour_formats, bool depth,
               GLenum filter)
    : width_(width), height_(height) {
  glGenFramebuffers(1, &name_);
  glBindFramebuffer(GL_FRAMEBUFFER, name_);
  std::vector<GLenum> attachments;
  for (GLenum format : colour_formats) {
    attachments.push_back(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + colour_.size()));
    colour_.push_back(MakeTexture(format, width, height, filter));
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, colour_.back(), 0);
  }
  glDrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
  if (depth) {
    depth_ = MakeTexture(GL_DEPTH_COMPONENT24, width, height, GL_NEAREST);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
  }
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("the graphics driver cannot draw off screen");
  }
}

Target::~Target() {
  glDeleteFramebuffers(1, &name_);
  glDeleteTextures(static_cast<GLsizei>(colour_.size()), colour_.data());
  glDeleteTextures(1, &depth_);
}

void Target::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, name_);
  glViewport(0, 0, width_, height_);
}

void Target::BindColour(int unit, size_t which) const {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, colour_[which]);
}

void Target::CopyColourTo(const Target& other) const {
  // At equal sizes there is nothing to average, and nearest is exact.
  bool same = width_ == other.width_ && height_ == other.height_;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, name_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, other.name_);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, other.width_, other.height_, GL_COLOR_BUFFER_BIT,
                    same ? GL_NEAREST : GL_LINEAR);
}

Image Target::Read() const {
  Image out(width_, height_);
  Bind();
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, out.rgb.data());
  return out;
}

void Target::CopyDepthTo(const Target& other) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, name_);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, other.name_);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void Target::BindDepth(int unit) const {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, depth_);
}

}  // namespace enamel::station::render
