#pragma once
#include <vtkGenericOpenGLRenderWindow.h>

#include <memory>

#include "furrow/base/result.h"

namespace furrow::figures {

/// VTK's render window on a context that somebody else made current.
class BorrowedContextWindow : public vtkGenericOpenGLRenderWindow {
 public:
  static BorrowedContextWindow* New();
  vtkTypeMacro(BorrowedContextWindow, vtkGenericOpenGLRenderWindow)

      void OpenGLInitContext() override;
  void MakeCurrent() override {}
  bool IsCurrent() override { return true; }
  int SupportsOpenGL() override { return 1; }
  vtkTypeBool IsDirect() override { return 1; }
};

/// An OpenGL 3.2 core context of Mesa's with neither display nor surface.
class SurfacelessContext {
 public:
  /// Errors: no_renderer.
  static Result<std::unique_ptr<SurfacelessContext>> create();
  SurfacelessContext(const SurfacelessContext&) = delete;
  SurfacelessContext& operator=(const SurfacelessContext&) = delete;
  ~SurfacelessContext();

  /// Binds the context to this thread; release() lets another thread take it.
  bool make_current() const;
  void release() const;

 private:
  SurfacelessContext(void* display, void* context) : display_(display), context_(context) {}
  void* display_;
  void* context_;
};

}  // namespace furrow::figures
