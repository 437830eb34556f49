#pragma once

#include <epoxy/gl.h>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "station/render/mesher.h"
#include "station/render/png_file.h"

// Owners of OpenGL names. All need the context current, also when destroyed. Not thread-safe.
namespace enamel::station::render {

// Throws std::runtime_error with the driver's log when the driver refuses the source.
class Program {
 public:
  // Sources may come in pieces.
  Program(std::initializer_list<const char*> vertex_source,
          std::initializer_list<const char*> fragment_source);
  ~Program() { glDeleteProgram(name_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void Use() const { glUseProgram(name_); }
  // Uniforms of the program in use. Unused names are ignored, as OpenGL does.
  void Set(const char* uniform, const glm::mat4& m) const;
  void Set(const char* uniform, const glm::vec3& v) const;
  void Set(const char* uniform, const glm::vec4& v) const;
  void Set(const char* uniform, float v) const;
  void Set(const char* uniform, int v) const;
  void Set(const char* uniform, std::span<const glm::vec3> v) const;
  void Set(const char* uniform, std::span<const float> v) const;

 private:
  int Location(const char* uniform) const { return glGetUniformLocation(name_, uniform); }
  GLuint name_ = 0;
};

// Indexed triangles of GpuVertex: attributes 0 position, 1 normal, 2 tissue or material, 3 look. Optionally
// coarser triangles of the same vertices.
class TriangleBuffer {
 public:
  TriangleBuffer();
  ~TriangleBuffer();
  TriangleBuffer(TriangleBuffer&& other) noexcept;
  TriangleBuffer(const TriangleBuffer&) = delete;
  TriangleBuffer& operator=(const TriangleBuffer&) = delete;

  void Upload(std::span<const GpuVertex> vertices, std::span<const uint32_t> indices,
              std::span<const uint32_t> coarse = {});
  // Draws the coarser triangles if `coarse` is set and there are any. Returns the number of
  // triangles.
  size_t Draw(bool coarse = false) const;
  size_t triangle_count() const { return static_cast<size_t>(count_) / 3; }

 private:
  GLuint array_ = 0, vertices_ = 0, indices_ = 0;
  GLsizei count_ = 0, coarse_count_ = 0;
};

// A framebuffer with colour textures and, optionally, a depth texture.
class Target {
 public:
  Target(int width, int height, std::initializer_list<GLenum> colour_formats, bool depth,
         GLenum filter);
  ~Target();
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  // Directs drawing here, over its whole size.
  void Bind() const;
  void BindColour(int unit, size_t which) const;
  void BindDepth(int unit) const;
  // Copies the first colour texture into the other's: averaged at half the size, stretched at other
  // sizes.
  void CopyColourTo(const Target& other) const;
  // Requires: equal sizes, both with depth.
  void CopyDepthTo(const Target& other) const;
  // The first colour texture. Waits for the drawing's end.
  Image Read() const;
  GLuint name() const { return name_; }
  GLuint colour() const { return colour_[0]; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  GLuint name_ = 0, depth_ = 0;
  std::vector<GLuint> colour_;
};

}  // namespace enamel::station::render
