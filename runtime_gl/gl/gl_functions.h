// SPDX-License-Identifier: Apache-2.0
// Lists exactly the OpenGL functions that this runtime calls. A back-end's GetProcAddress loads them. Loader libraries
// were tested and do not work. libepoxy crashes under OSMesa 22.3.6, and GLEW does not find OSMesa's functions.
// GetProcAddress returns an address even for names that do not exist, so the version is checked first.
#pragma once

#include <GL/glcorearb.h>

#include <string>

namespace multum::gl {

// X(type, name) declares the function gl`name` as member `name`. Entries are sorted by the part of OpenGL that defines
// the function.
#define MULTUM_GL_FUNCTIONS(X)                                           \
  X(PFNGLGETSTRINGPROC, GetString)                                       \
  X(PFNGLGETSTRINGIPROC, GetStringi)                                     \
  X(PFNGLGETINTEGERVPROC, GetIntegerv)                                   \
  X(PFNGLGETFLOATVPROC, GetFloatv)                                       \
  X(PFNGLGETERRORPROC, GetError)                                         \
  X(PFNGLDEBUGMESSAGECALLBACKPROC, DebugMessageCallback)                 \
  X(PFNGLENABLEPROC, Enable)                                             \
  X(PFNGLDISABLEPROC, Disable)                                           \
  X(PFNGLBLENDFUNCPROC, BlendFunc)                                       \
  X(PFNGLVIEWPORTPROC, Viewport)                                         \
  X(PFNGLSCISSORPROC, Scissor)                                           \
  X(PFNGLFINISHPROC, Finish)                                             \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                                   \
  X(PFNGLREADPIXELSPROC, ReadPixels)                                     \
  X(PFNGLCREATETEXTURESPROC, CreateTextures)                             \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures)                             \
  X(PFNGLTEXTURESTORAGE2DPROC, TextureStorage2D)                         \
  X(PFNGLTEXTURESTORAGE3DPROC, TextureStorage3D)                         \
  X(PFNGLTEXTURESUBIMAGE3DPROC, TextureSubImage3D)                       \
  X(PFNGLCOMPRESSEDTEXTURESUBIMAGE3DPROC, CompressedTextureSubImage3D)   \
  X(PFNGLTEXTURESUBIMAGE2DPROC, TextureSubImage2D)                       \
  X(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                       \
  X(PFNGLTEXTUREPARAMETERFPROC, TextureParameterf)                       \
  X(PFNGLTEXTUREPARAMETERFVPROC, TextureParameterfv)                     \
  X(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                           \
  X(PFNGLGETTEXTUREIMAGEPROC, GetTextureImage)                           \
  X(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                     \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                     \
  X(PFNGLNAMEDFRAMEBUFFERTEXTUREPROC, NamedFramebufferTexture)           \
  X(PFNGLNAMEDFRAMEBUFFERRENDERBUFFERPROC, NamedFramebufferRenderbuffer) \
  X(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERSPROC, NamedFramebufferDrawBuffers)   \
  X(PFNGLNAMEDFRAMEBUFFERREADBUFFERPROC, NamedFramebufferReadBuffer)     \
  X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus)   \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                           \
  X(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, ClearNamedFramebufferfv)           \
  X(PFNGLCREATERENDERBUFFERSPROC, CreateRenderbuffers)                   \
  X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                   \
  X(PFNGLNAMEDRENDERBUFFERSTORAGEPROC, NamedRenderbufferStorage)         \
  X(PFNGLCREATESHADERPROC, CreateShader)                                 \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                                 \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                               \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                                   \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                         \
  X(PFNGLDELETESHADERPROC, DeleteShader)                                 \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                               \
  X(PFNGLATTACHSHADERPROC, AttachShader)                                 \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                                   \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                 \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                       \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                               \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                                     \
  X(PFNGLGETACTIVEUNIFORMPROC, GetActiveUniform)                         \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                     \
  X(PFNGLPROGRAMUNIFORM1IPROC, ProgramUniform1i)                         \
  X(PFNGLPROGRAMUNIFORM1IVPROC, ProgramUniform1iv)                       \
  X(PFNGLPROGRAMUNIFORM1FVPROC, ProgramUniform1fv)                       \
  X(PFNGLPROGRAMUNIFORM1FPROC, ProgramUniform1f)                         \
  X(PFNGLPROGRAMUNIFORM2FVPROC, ProgramUniform2fv)                       \
  X(PFNGLPROGRAMUNIFORM3FVPROC, ProgramUniform3fv)                       \
  X(PFNGLPROGRAMUNIFORMMATRIX4FVPROC, ProgramUniformMatrix4fv)           \
  X(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                     \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                     \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                           \
  X(PFNGLENABLEVERTEXARRAYATTRIBPROC, EnableVertexArrayAttrib)           \
  X(PFNGLVERTEXARRAYATTRIBFORMATPROC, VertexArrayAttribFormat)           \
  X(PFNGLVERTEXARRAYATTRIBBINDINGPROC, VertexArrayAttribBinding)         \
  X(PFNGLVERTEXARRAYVERTEXBUFFERPROC, VertexArrayVertexBuffer)           \
  X(PFNGLVERTEXARRAYELEMENTBUFFERPROC, VertexArrayElementBuffer)         \
  X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                               \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                               \
  X(PFNGLNAMEDBUFFERSTORAGEPROC, NamedBufferStorage)                     \
  X(PFNGLCREATEQUERIESPROC, CreateQueries)                               \
  X(PFNGLDELETEQUERIESPROC, DeleteQueries)                               \
  X(PFNGLBEGINQUERYPROC, BeginQuery)                                     \
  X(PFNGLENDQUERYPROC, EndQuery)                                         \
  X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                   \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                                     \
  X(PFNGLDRAWELEMENTSPROC, DrawElements)

struct GlFunctions {
#define MULTUM_GL_MEMBER(type, name) type name = nullptr;
  MULTUM_GL_FUNCTIONS(MULTUM_GL_MEMBER)
#undef MULTUM_GL_MEMBER
};

using GlFunction = void (*)();
using GetProcAddress = GlFunction (*)(const char*);

/// Fills the table for the current context. Throws Error(kEnvironment) below OpenGL 4.5, or if a function is missing.
GlFunctions load_gl_functions(GetProcAddress get_proc_address);

/// Returns whether the current context lists `extension`.
bool has_gl_extension(const GlFunctions& gl, const char* extension);

/// Returns GL_VENDOR, GL_RENDERER or GL_VERSION, or "?" if the driver returns null.
std::string gl_string(const GlFunctions& gl, GLenum name);

/// Returns a name such as "GL_INVALID_OPERATION".
const char* gl_error_name(GLenum error);

/// Clears all error flags. Throws Error(kEnvironment) "`step`: GL_..." if any was set.
void check_gl(const GlFunctions& gl, const std::string& step);

}  // namespace multum::gl
