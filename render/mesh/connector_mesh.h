// Connectors as geometry: chains of real links between swivels, ropes and cords as tubes.
#pragma once

#include <memory>
#include <span>

#include "render/mesh/chain_mesh.h"
#include "scenes/scene/stage.h"
#include "sim/world/connector.h"

namespace taut::mesh {

/// The geometry of `connector`, drawn as `look` says; its holds tell where swivels sit on bodies,
/// whose models (null: none) tell how thick they are there.
std::unique_ptr<ConnectorMesh> make_connector_mesh(
    const Connector& connector, const scenes::ConnectorLook& look,
    std::span<const std::shared_ptr<const scenes::Model>> bodies);

}  // namespace taut::mesh
