#include "tools/report/svg_picture.h"

#include <cmath>
#include <memory>

#include <librsvg/rsvg.h>

namespace t4d::tools {
namespace {

template <auto release>
struct Releases {
  void operator()(auto* object) const { release(object); }
};
using Stream = std::unique_ptr<GInputStream, Releases<g_object_unref>>;
using Drawing = std::unique_ptr<RsvgHandle, Releases<g_object_unref>>;
using Surface = std::unique_ptr<cairo_surface_t, Releases<cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Releases<cairo_destroy>>;

Error cannotDraw(GError* reason) {
  const std::string message = reason ? reason->message : "no reason is given";
  g_clear_error(&reason);
  return fail(ErrorCode::Failed, "the picture cannot be drawn: " + message);
}

cairo_status_t append(void* text, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Result<std::string> pngOfSvg(const std::string& svg, double pixelsPerUnit) {
  GError* error = nullptr;
  const Stream stream(
      g_memory_input_stream_new_from_data(svg.data(), static_cast<gssize>(svg.size()), nullptr));
  const Drawing drawing(rsvg_handle_new_from_stream_sync(
      stream.get(), nullptr, RSVG_HANDLE_FLAG_UNLIMITED, nullptr, &error));
  if (!drawing) return cannotDraw(error);
  RsvgRectangle box{};
  gboolean hasBox = FALSE;
  rsvg_handle_get_intrinsic_dimensions(drawing.get(), nullptr, nullptr, nullptr, nullptr, &hasBox,
                                       &box);
  const RsvgRectangle view{0, 0, std::ceil(box.width * pixelsPerUnit),
                           std::ceil(box.height * pixelsPerUnit)};
  const Surface surface(cairo_image_surface_create(
      CAIRO_FORMAT_ARGB32, static_cast<int>(view.width), static_cast<int>(view.height)));
  const Context context(cairo_create(surface.get()));
  if (!rsvg_handle_render_document(drawing.get(), context.get(), &view, &error)) {
    return cannotDraw(error);
  }
  std::string png;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), append, &png);
  if (status != CAIRO_STATUS_SUCCESS) {
    return fail(ErrorCode::Failed,
                std::string("the picture cannot be written: ") + cairo_status_to_string(status));
  }
  return png;
}

}  // namespace t4d::tools
