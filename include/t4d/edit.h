#pragma once

/// New meshes from old ones: mended, simplified, resolved, cut into slabs, made of tetrahedra from
/// elsewhere.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// Options and limits of mendSurface, in length units.
struct MendSurfaceOptions {
  /// Merge vertices no farther apart than this along each axis; 0 merges equal ones.
  double weld = 0;
  /// Fill no hole wider than this: the largest distance between two vertices of its boundary.
  std::optional<double> maxHole = {};
  /// Return no surface with a point farther than this from the input's.
  std::optional<double> maxMove = {};
  /// If nothing else helps, make a new surface from voxels of this size (remesh_surface.h).
  std::optional<double> remesh = {};
  /// Give sheets this thickness: open surfaces that would enclose nothing if their holes were
  /// filled.
  std::optional<double> thicken = {};
};

enum class SurfaceFault : std::uint8_t {
  Doubled,      ///< vertices near each other, merged
  Duplicate,    ///< triangles with the corners of another one, or with a corner twice, dropped
  Stray,        ///< triangles that hang at an edge of a surface, or divide its inside, dropped
  Turned,       ///< triangles that disagreed with their neighbours, turned
  Sheet,        ///< sheets, which got a thickness
  Hole,         ///< holes, filled
  InsideOut,    ///< components that faced inward, turned
  Crossing,     ///< pairs of triangles that met; the outer surface was taken
  NonManifold,  ///< vertices and edges where surfaces touched, taken apart
  Remeshed,     ///< triangles of a new surface in place of the input's
  Hull,         ///< triangles of the convex hull in place of the input's
};

struct SurfaceChange {
  SurfaceFault kind = SurfaceFault::Doubled;
  std::uint64_t count = 0;
  std::string text;  ///< what was done, as a sentence without a full stop
};

/// The word for a kind in JSON.
const char* nameOf(SurfaceFault kind);

/// The parts of the input outside of the mended solid: fins, sheets, parts that were inside out.
struct LostSurface {
  std::uint64_t triangles = 0;  ///< of the input that reach out of the solid
  double distance = 0;          ///< how far they do, in length units
};

struct MendSurfaceReport {
  std::vector<SurfaceChange> changes;
  /// The Hausdorff distance between the surfaces before and after, in length units. It may be too
  /// small by a ten-thousandth of their diagonal.
  double hausdorff = 0;
  /// The volume that the input encloses, what overlaps counted again; nothing if it was open.
  std::optional<double> volumeBefore = {};
  double volumeAfter = 0;
  model::Bounds3 boundsBefore = {};  ///< of triangles, without unused vertices
  model::Bounds3 boundsAfter = {};
  /// What was dropped outside of the result, if it reaches farther out than a thousandth of the
  /// diagonal, the distance of `weld`, and two voxels of `remesh` where that was needed.
  LostSurface lost = {};
  // Properties of the result. Always true if mendSurface succeeds.
  bool closed = false;
  bool manifold = false;
  /// 0; nothing where they are accepted, and in a build without CGAL, which does not look for them.
  std::optional<std::uint64_t> selfIntersections = {};
  std::uint64_t components = 0;
};

/// Changes a surface so that it bounds a solid: closed, manifold, facing outward, without
/// self-intersections and flat triangles, also after equal vertices are merged. In this order:
/// 1. merges vertices; drops triangles that this collapses, and equal triangles: both where solids
///    meet back to back and in sheets with two sides, all but one where one is given again;
/// 2. drops stray parts: where an odd number of triangles, three or more, meet at edges, the
///    smallest part between such edges whose removal leaves no fewer than two at each, unless it is
///    a solid with a hole: it has more than twice the area that closes its rim;
/// 3. turns triangles so that neighbours agree; in each component, those with less area in total.
///    Nothing is turned where each edge is traversed equally often in both directions;
/// 4. gives sheets a thickness, if there is one; fills holes, without new vertices;
/// 5. turns components that enclose a negative volume and are not inside another one;
/// 6. takes the outer surface, the boundary of where the winding number is 1 or more, if triangles
///    cross, overlap, touch or are flat, if edges have more than two triangles, and if components
///    are nested without being cavities;
/// 7. separates parts that touch at vertices and edges: each copy of a vertex moves into its solid,
///    or in another direction if that leaves fewer crossings, by a hundred-thousandth of the
///    diagonal or a tenth of its shortest edge if that is less.
///
/// A surface without such faults is not changed. All decisions use exact predicates, except for
/// winding numbers, which must be close to integers. On failure nothing is changed. Fails if
/// the result would exceed the limits or could not be made; the remedy of the error is the option
/// that helps: Remesh, MaxHole or MaxMove. Attributes are carried along (carried_attributes.h). A
/// build without CGAL does not look for crossings and flat triangles, and fails if there are holes
/// or nested components.
Result<MendSurfaceReport> mendSurface(model::TriangleMesh& mesh,
                                      const MendSurfaceOptions& options = {},
                                      const model::Progress& progress = {});

/// Replaces a surface, closed or not, by the convex hull of its triangles, whose vertices are some
/// of its own: an upper bound of the solid, as planners of robots take it. Of the report, the
/// change is a Hull, and nothing is lost; the Hausdorff distance may be too small by a thousandth
/// of the diagonal. Attributes are those of the nearest points. Fails if all points are in a plane,
/// and in a build without CGAL; on failure nothing is changed.
Result<MendSurfaceReport> hullSurface(model::TriangleMesh& mesh);

struct SimplifyOptions {
  /// The fraction of the cells to keep: above 0, at most 1.
  std::optional<double> ratio = {};
  /// The maximum distance of slices from those of the given mesh, in length units.
  std::optional<double> maxError = {};
  /// The length that one unit of time counts as, to weigh errors in space and time. It is rounded
  /// to a power of two, so that times keep their bits.
  double timeScale = 1;
  /// The name of a cell attribute; borders between cells with different values are kept. "" for
  /// none.
  std::string preserve = {};
  /// The number of slabs that become one. By default as many as have `windowCells` cells become one
  /// first, and then as many of these as are to have half as many cells left.
  std::optional<std::uint64_t> windowSlabs = {};
  std::uint64_t windowCells = 250'000;
  /// Simplifies only some of the windows. Layers where parts meet are not changed, so parts
  /// simplified with the same options fit together (formats::joinT4d).
  model::Part part = {};
};

/// The numbers of a part are those of its slabs only.
struct SimplifyReport {
  std::array<std::size_t, 2> slabs = {};  ///< first slab of the source, and one past the last
  std::uint64_t cellsBefore = 0;
  std::uint64_t cells = 0;
  std::uint64_t verticesBefore = 0;
  std::uint64_t vertices = 0;
  double hypervolumeBefore = 0;
  double hypervolume = 0;
  /// A bound on the Hausdorff distance between slices of the result and of the given mesh at the
  /// same time; at most SimplifyOptions::maxError. Nothing without this option.
  std::optional<double> maxError = {};
  std::set<std::string> droppedAttributes = {};  ///< names of attributes that only some slabs have
};

/// Puts a closed 4D mesh with fewer cells into `sink`: edges are collapsed, first those that change
/// the shape least (collapsed). The result is the same 3-manifold and lasts as long. Its
/// hypervolume is the same up to rounding, and the topology of its slices changes at the same
/// times. With a maximum error, it is proved that slices stay within it (provedCollapse), which
/// takes many times as long. Vertex attributes are interpolated along edges; remaining cells keep
/// their attributes.
///
/// Slabs are grouped into windows, each of which becomes one slab; a slab without thickness is a
/// window of its own. Each window is simplified except for its first and last layer; then each
/// layer between two windows, with the cells on both sides. Windows with few cells left become one,
/// since a layer that stays needs more cells than the shape. Two windows, and one more for each
/// thread, are in memory; with a maximum error also what they were made from. The result does not
/// depend on the number of threads.
///
/// Reads the mesh, or its part, twice. Fails for a mesh that is not closed, oriented and manifold
/// (except at the apex of a conical cap), for contradictory options, and for more parts than
/// windows.
Result<SimplifyReport> simplify(const model::Source& source, const SimplifyOptions& options,
                                model::Sink& sink, const model::Progress& progress = {});

struct ResolveOptions {
  double clearance = 0;  ///< the distance to keep, in length units; 0: no touching
  /// How far around a contact the surface gives way, in length units; by default three times the
  /// largest displacement, and at least two mean edges.
  std::optional<double> smoothSpace = {};
  /// How long before and after a contact the surface gives way, in time units; by default a tenth
  /// of the body's time.
  std::optional<double> smoothTime = {};
  /// The largest displacement, in length units; by default half of the smallest extent of the body.
  std::optional<double> maxMove = {};
  bool stay = false;  ///< keep dents after the contact
  int maxRounds = 24;
};

/// The solid at the time of a layer.
struct ResolvedLayer {
  double time = 0;
  double volumeBefore = 0;
  double volumeAfter = 0;
  double displacement = 0;  ///< the largest, in length units
};

struct ResolveReport {
  bool changed = false;  ///< false if the body was clear already
  double maxDisplacement = 0;
  double maxDisplacementTime = 0;
  model::Point3 maxDisplacementPlace = model::Point3::Zero();  ///< before displacement
  double volumeChangeMax = 0;  ///< the largest change of the volume at a layer, with its sign
  double hypervolumeChange = 0;
  std::uint64_t rounds = 0;         ///< tests for contact after a change
  std::uint64_t movedVertices = 0;  ///< in all layers together
  std::uint64_t addedLayers = 0;    ///< within steps of the body
  double smoothSpace = 0;           ///< as used
  double smoothTime = 0;
  std::vector<ResolvedLayer> layers;  ///< in time order
};

/// The result of resolve: a body that gives way.
struct ResolvedBody {
  /// The body, with the vertex attribute "displacement" (three float32) if it is changed. Valid as
  /// long as the source that was given.
  std::shared_ptr<const model::Source> source;
  ResolveReport report;
};

/// Deforms `body` in space and time so that it does not touch any of `obstacles` or come nearer
/// than the clearance, by the exact test of cells in space-time (measure/collide.h).
///
/// Vertices of layers that are in an obstacle, or too near, move out along the shortest way. If
/// these ways diverge, as on both sides of a thin plate, they move towards the inside of the body.
/// Around them the surface gives way over `smoothSpace` and `smoothTime`. Where several contacts
/// overlap, the largest displacement counts; what is out of reach of all stays unchanged, bit for
/// bit. Where the bodies touch between layers that are clear, the step is divided. This is repeated
/// until nothing touches.
///
/// The body must keep its triangles, as swept ones do (VertexTracks). Fails with ErrorCode::Failed,
/// with the time and the position, if the body cannot get out of the way within `maxMove`, or if
/// its surface would have to cross itself.
Result<ResolvedBody> resolve(std::span<const model::Body> obstacles, const model::Body& body,
                             const ResolveOptions& options, const model::Progress& progress = {});

/// A layer where a run of consecutive slabs begins or ends and the mesh is open.
struct RunEnd {
  std::uint64_t slab = 0;  ///< the slab with this layer, counted among those put
  double time = 0;
  bool begin = false;           ///< the run begins here; otherwise it ends here
  std::uint64_t triangles = 0;  ///< facets closed
  /// The number of cells of the cap: one for each facet, or four where a part of the surface
  /// touches itself.
  std::uint64_t cells = 0;
  /// Why the facets could not be closed; the mesh stays open here.
  std::optional<std::string> open;
};

/// Turns a subset of the slabs of a closed mesh into a closed mesh. It takes slabs in time order
/// and passes them on. Where slabs are missing, it adds two slabs without thickness: one ends the
/// run before the gap, the other begins the run after it. Each is a cone over the facets that the
/// missing slab shared:
///
///                       apexes
///      *-----*-----*    /  |  \     the cap: each open facet of the layer is joined to an apex at
///       \  .   .  /    *---*---*    the same time, one apex per connected part of them
///
/// The open facets of a mesh that is closed elsewhere form a closed surface, the slice at that
/// time, so the cone closes the mesh. It encloses nothing: the hypervolume and the slices of the
/// given slabs stay exact. A part that touches itself at a vertex has a layer of prisms before its
/// cone, so that the vertex has a cap on each side. The mesh is empty in the gap. As with any cone,
/// cells may overlap within the cap.
///
/// Two slabs are consecutive if the upper layer of one equals the lower layer of the next (-0
/// equals 0). A cap cell has the attributes of the cell whose facet it closes, except "kind" and
/// "triangle" (formats/t4d/SPEC.md, section "Registries"). An apex has the attributes of a
/// vertex of its surface.
class RunCloser : public model::Sink {
 public:
  /// `sink` must outlive this object.
  explicit RunCloser(model::Sink& sink) : sink_(sink) {}

  Result<void> put(const model::Slab& slab) override;

  /// Ends the last run. Returns where runs began and ended with open facets, in time order.
  Result<std::vector<RunEnd>> finish();

 private:
  Result<void> beginRun(const model::Slab& slab);
  Result<void> endRun(bool another);
  Result<void> putCap(const model::Slab& neighbour, bool begin, bool needed);

  model::Sink& sink_;
  std::optional<model::Slab> last_;
  std::uint64_t count_ = 0;  // slabs put so far
  std::vector<RunEnd> ends_;
};

struct Mend4dOptions {
  /// Merge vertices no farther apart than this along each axis, time included; 0 merges equal ones.
  /// By default, equal vertices are merged only if the mesh is open.
  std::optional<double> weld = {};
  /// Accept a mesh that is not closed or cannot be oriented.
  bool allowOpen = false;
};

struct Mend4dReport {
  bool closed = false;    ///< every triangle has exactly two tetrahedra
  bool oriented = false;  ///< the two are on opposite sides
  /// Changes that were made and faults that remain, one sentence each.
  std::vector<std::string> changes;
};

/// Makes a body of another program's mesh: closed, oriented, facing outward. Makes only changes
/// without a choice:
/// * vertices are merged, according to the options;
/// * tetrahedra that disagree with their neighbours are turned, so that each connected part
///   encloses a positive hypervolume. A cavity becomes a solid, since a mesh without orientation
///   does not distinguish the two;
/// * a mesh that is oriented but encloses a negative hypervolume is turned inside out.
///
/// Fails if the mesh is not closed or cannot be oriented, naming the first triangle at fault, or
/// encloses no hypervolume, unless the options allow it.
Result<Mend4dReport> mendMesh4d(formats::Mesh4d& mesh, const Mend4dOptions& options = {});

struct SlabCuts {
  /// The number of slabs. Tetrahedra that span a cut are split there. There are fewer slabs if the
  /// vertices have too few times. Without this, the mesh is cut only where no tetrahedron is split,
  /// into slabs of at least some hundred tetrahedra, so a swept mesh gets its layers back.
  std::optional<std::uint64_t> slabs = {};
};

struct CutMesh {
  model::Mesh mesh;
  std::uint64_t splitTetrahedra = 0;  ///< tetrahedra that spanned a cut
  std::uint64_t newVertices = 0;
};

/// Cuts a closed mesh into slabs at times of its own vertices. Where an edge crosses a cut it gets
/// a new vertex, which all its tetrahedra share, at exactly that time (CellSplitter). The solid
/// stays the same: hypervolume and slices change by no more than the rounding of the new vertices.
///
/// Fails if two tetrahedra that would be split have the same corners.
Result<CutMesh> cutIntoSlabs(formats::Mesh4d mesh, const SlabCuts& cuts = {});

/// Anybody's 4D tetrahedra as a 4D mesh: mendMesh4d, which turns them outward, and cutIntoSlabs. A
/// point has x, y, z and t; a cell has the numbers of four points, in any order. Fails for numbers
/// out of range, and if either of the two does.
Result<model::Mesh> fromTetrahedra(std::span<const model::Point4> points,
                                   std::span<const model::Cell> cells);

}  // namespace t4d::edit

namespace t4d {
using edit::fromTetrahedra;
}  // namespace t4d
