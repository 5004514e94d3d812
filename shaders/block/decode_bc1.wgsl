// Decodes BC1 blocks, one block per invocation. Needs `bc1_texels`.

@group(0) @binding(0) var<storage, read> blocks: array<u32>;
@group(0) @binding(1) var<storage, read_write> texels: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn decode_bc1(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let block = id.x + id.y * groups.x * WORKGROUP;
    if (block >= arrayLength(&blocks) / 2u) {
        return;
    }
    let at = 2u * block;
    let words = vec2u(blocks[at], blocks[at + 1u]);
    var pixels: array<u32, 16>;
    bc1_texels(words, &pixels);
    for (var texel = 0u; texel < 16u; texel++) {
        texels[16u * block + texel] = pixels[texel];
    }
}
