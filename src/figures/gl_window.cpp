#include "figures/gl_window.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <vtk_glew.h>
#include <vtkObjectFactory.h>

#include <array>
#include <string>

namespace furrow::figures {
namespace {

Error no_renderer(const std::string& what) {
  return {"no_renderer", "figures", what + " (EGL error " + std::to_string(eglGetError()) + ")",
          "Mesa's surfaceless OpenGL 3.2", "install libegl1 libegl-mesa0 libgl1-mesa-dri"};
}

}  // namespace

vtkStandardNewMacro(BorrowedContextWindow);

void BorrowedContextWindow::OpenGLInitContext() {
  if (this->Initialized) return;
  // Code 4: GLEW looked for a GLX display after it had loaded every entry point; there is none and none is
  // needed.
  constexpr GLenum kNoGlxDisplay = 4;
  glewExperimental = GL_TRUE;
  const GLenum code = glewInit();
  this->Initialized = code == GLEW_OK || code == kNoGlxDisplay;
}

Result<std::unique_ptr<SurfacelessContext>> SurfacelessContext::create() {
  // The cast is how EGL hands out its extension functions.
  const auto platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (platform_display == nullptr) return no_renderer("EGL has no platform displays");
  const EGLDisplay display = platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  if (display == EGL_NO_DISPLAY) return no_renderer("EGL has no surfaceless platform");
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) return no_renderer("EGL did not start");
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return no_renderer("EGL has no desktop OpenGL");
  constexpr std::array<EGLint, 7> kCore32{EGL_CONTEXT_MAJOR_VERSION,
                                          3,
                                          EGL_CONTEXT_MINOR_VERSION,
                                          2,
                                          EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                          EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                          EGL_NONE};
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kCore32.data());
  if (context == EGL_NO_CONTEXT) return no_renderer("EGL gave no OpenGL 3.2 core context");
  std::unique_ptr<SurfacelessContext> made(new SurfacelessContext(display, context));
  if (!made->make_current()) return no_renderer("the OpenGL context could not be made current");
  made->release();
  return made;
}

SurfacelessContext::~SurfacelessContext() {
  release();
  eglDestroyContext(display_, context_);
}

bool SurfacelessContext::make_current() const {
  // The bound API is per thread.
  return eglBindAPI(EGL_OPENGL_API) == EGL_TRUE &&
         eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
}

void SurfacelessContext::release() const {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace furrow::figures
