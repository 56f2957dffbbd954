// SPDX-License-Identifier: GPL-3.0-or-later
// Programs: looked up, folded, and evaluated at surface points.
#pragma once

#include <memory>
#include <string>

#include "material/machine.h"
#include "material/texture_store.h"
#include "scene/closures.h"
#include "scene/opacity.h"
#include "scene/scene.h"

namespace penumbra {

/// The operation of a name; null if there is none.
const NamedOperation* find_operation(const std::string& name);
std::vector<std::string> operation_names();

/// Evaluates operations whose inputs are constants once and for all, and drops them.
void fold(Program& program);

/// What of a program the closures of one kind take, transparency's or emission's, whose colour is all there
/// is.
Program part_of(const Program& program, ClosureKind kind);

/// True if the closures are the same wherever and from wherever the surface is seen.
bool is_constant(const Program& program);

/// How a surface point was found.
struct Seen {
  Vec3d direction;  // of the ray, any length
  RayKind ray;
  double footprint = 0;  // width of a pixel at the point, render space
};

/// A scene's materials at surface points. Threads may evaluate at the same time.
class Materials final : public Opacity {
 public:
  /// Starts the texture system if the scene has images, but for those that a store has. The scene's materials
  /// must not change any more.
  explicit Materials(std::shared_ptr<const Scene> scene, TextureStore* store = nullptr);

  /// The closures at a surface point; its shading normal is replaced where the material bumps it.
  Closures evaluate(const Program& program, PlacedPoint& surface, const Seen& seen) const;

  bool may_be_transparent(uint32_t material) const override;
  double transparency(const PlacedPoint& surface, const Vec3d& direction, uint8_t channel) const override;

  /// See Textures::problems().
  std::vector<std::string> problems() const;

 private:
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Textures> textures_;
};

/// Closures of a program without operations, by its constants; for folded materials.
Closures constant_closures(const Program& program);

}  // namespace penumbra
