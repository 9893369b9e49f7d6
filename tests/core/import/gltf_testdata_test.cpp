#include "tests/core/import/real_scene.h"

namespace qray {
namespace {

using test::RealScene;

class GltfTestdata : public testing::TestWithParam<RealScene> {};

TEST_P(GltfTestdata, Loads) { test::expect_loads(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    All, GltfTestdata,
    testing::Values(
        RealScene{"gltf-bathroom/LAZIENKA.glb", 38555, 0},
        RealScene{"gltf-cornell-bevy/CornellBox.glb", 36, 0},
        RealScene{"gltf-features/01_alpha_blend/01_alpha_blend.gltf", 14, 0},
        RealScene{"gltf-features/01_alpha_mask/01_alpha_mask.gltf", 2, 0},
        RealScene{"gltf-features/01_color_attribute/01_color_attribute.gltf", 1, 0},
        RealScene{"gltf-features/01_metallic_sphere/01_metallic_sphere.gltf", 960, 0},
        RealScene{"gltf-features/01_plane/01_plane.gltf", 2, 0},
        RealScene{"gltf-features/01_principled_material/01_principled_material.gltf", 24, 0},
        RealScene{"gltf-features/01_single_vs_double_sided/01_single_vs_double_sided.gltf", 1480,
                  0},
        RealScene{"gltf-features/01_unlit/01_unlit.gltf", 88, 0},
        RealScene{"gltf-features/02_node_hierarchy/02_node_hierarchy.gltf", 60, 0},
        RealScene{"gltf-features/02_shared_mesh/02_shared_mesh.gltf", 12, 0},
        RealScene{"gltf-features/04_common_materials/04_common_materials.gltf", 974, 0},
        RealScene{"gltf-features/08_combine_orm/08_combine_orm.gltf", 12, 0},
        RealScene{"gltf-features/09_texture_transform/09_texture_transform.gltf", 2, 0},
        RealScene{"gltf-features/10_custom_normals/10_custom_normals.gltf", 88, 0},
        RealScene{"gltf-features/11_factors_and_textures/11_factors_and_textures.gltf", 12, 0},
        RealScene{"gltf-features/12_orm_two_uvmaps/12_orm_two_uvmaps.gltf", 12, 0},
        RealScene{"gltf-features/13_texture_wrapping/13_texture_wrapping.gltf", 4, 0},
        RealScene{"gltf-features/14_emission_strength/14_emission_strength.gltf", 17280, 0},
        RealScene{"gltf-features/15_transmission/15_transmission.gltf", 4800, 0},
        RealScene{"gltf-features/16_volume/16_volume.gltf", 236, 0},
        RealScene{"gltf-features/17_ior/17_ior.gltf", 60, 0},
        RealScene{"gltf-features/18_variants/18_variants.gltf", 12, 1},
        RealScene{"gltf-features/19_sheen/19_sheen.gltf", 6720, 0},
        RealScene{"gltf-features/22_factors/22_factors.gltf", 12, 0},
        RealScene{"gltf-features/22_vertex_color/22_vertex_color.gltf", 5, 2},
        RealScene{"gltf-features/24_gpu_instancing/24_gpu_instancing.gltf", 4034, 0},
        RealScene{"gltf-features/25_anisotropy/25_anisotropy.gltf", 10264, 0},
        RealScene{"many-lights-a/many-lights-a-punctual.gltf", 18, 0},
        RealScene{"many-lights-a/many-lights-a.glb", 192418, 0},
        RealScene{"xf-cornell-box/cornell-box.gltf", 20, 0},
        RealScene{"xf-cornell-box/cornell-box.glb", 20, 0},
        RealScene{"xf-staircase2/staircase2.glb", 30983, 0},
        RealScene{"xf-veach-ajar/veach-ajar.glb", 382690, 0}));

}  // namespace
}  // namespace qray
