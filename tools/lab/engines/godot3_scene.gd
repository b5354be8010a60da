# SPDX-License-Identifier: Apache-2.0
# Draws a metal floor in Godot 3, and stores one frame. tools/lab/godot_pictures.py runs it.
#   godot3 -s godot3_scene.gd FOLDER PICTURE.png WIDTH HEIGHT own|fitted|none
# own: level 0 with the mip levels that Godot makes; fitted: the levels that tools/engines/godot3_levels.gd joined;
# none: level 0 without mip levels, for a picture that is averaged afterwards.
extends SceneTree

const ROUGHNESS := 0.3
const FRAME := 8  # the first frames have other sizes

var frame := 0
var picture := ""


func _init():
	var words := Array(OS.get_cmdline_args()).slice(-5, -1)
	var folder: String = words[0]
	var kind: String = words[4]
	picture = words[1]
	OS.window_size = Vector2(int(words[2]), int(words[3]))
	var material := SpatialMaterial.new()
	material.metallic = 1.0
	material.albedo_color = Color(0.9, 0.8, 0.7)
	material.normal_enabled = true
	material.normal_texture = texture(folder.plus_file("normal"), kind)
	material.roughness = ROUGHNESS
	if kind == "fitted":
		material.roughness = 1.0
		material.roughness_texture = texture(folder.plus_file("orm"), kind)
		material.roughness_texture_channel = SpatialMaterial.TEXTURE_CHANNEL_GREEN
	material.uv1_scale = Vector3(24, 24, 1)
	var floor_mesh := PlaneMesh.new()
	floor_mesh.size = Vector2(24, 24)
	var ground := MeshInstance.new()
	ground.mesh = floor_mesh
	ground.material_override = material
	var light := DirectionalLight.new()
	light.rotation_degrees = Vector3(-25, 160, 0)
	light.light_energy = 0.35
	var camera := Camera.new()
	camera.translation = Vector3(0, 1.6, 11)
	camera.rotation_degrees = Vector3(-14, 0, 0)
	camera.fov = 45
	var surroundings := WorldEnvironment.new()
	surroundings.environment = Environment.new()
	surroundings.environment.background_mode = Environment.BG_COLOR
	surroundings.environment.background_color = Color(0.25, 0.3, 0.4)
	surroundings.environment.ambient_light_color = Color(0.3, 0.35, 0.45)
	surroundings.environment.ambient_light_energy = 0.5
	for node in [ground, light, camera, surroundings]:
		root.add_child(node)
	camera.current = true


func texture(stem: String, kind: String) -> ImageTexture:
	var made := ImageTexture.new()
	var flags := Texture.FLAG_REPEAT | Texture.FLAG_FILTER
	if kind != "none":
		flags |= Texture.FLAG_MIPMAPS | Texture.FLAG_ANISOTROPIC_FILTER
	var image: Image
	if kind == "fitted":
		image = load(stem + ".res")
	else:
		image = Image.new()
		image.load(stem + "_00.png")
		if kind == "own":
			image.generate_mipmaps(true)  # as for a normal map: the levels have unit length
	made.create_from_image(image, flags)
	return made


func _iteration(_delta):
	frame += 1
	if frame == FRAME:
		var image := root.get_texture().get_data()
		image.flip_y()
		image.save_png(picture)
		quit()
	return false
