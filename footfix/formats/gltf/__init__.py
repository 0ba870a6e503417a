"""glTF: GLB, .gltf, VRM and VRM animation, read strictly and written with only those channels new that changed."""
