#include "tools/t4d/envelope_page.h"

#include "tools/report/solid_picture.h"

namespace t4d::tools {

std::string envelopePage(const std::string& title, const CaptionedSolids& solids, bool zUp,
                         const Table& numbers) {
  model::Bounds3 bounds;
  for (const auto& [caption, mesh] : solids) bounds.add(boundsOf(mesh));
  const View view = viewOf(bounds, zUp);
  std::string html;
  for (const auto& [caption, mesh] : solids) {
    html += figureOf(mesh, always(html.empty() ? kOrange : kBlue), view, caption);
  }
  return htmlPage(title, figuresOf(html) + tableOf(numbers));
}

}  // namespace t4d::tools
