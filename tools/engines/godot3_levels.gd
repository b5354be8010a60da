# SPDX-License-Identifier: Apache-2.0
# Joins the levels that `multum export --for godot --format png` wrote into images that Godot 3 loads with these levels.
# Godot 3 loads no DDS or KTX2 files of multum, and makes its own mip levels for PNG files.
#   godot3-server -s godot3_levels.gd FOLDER
# For FOLDER/normal_00.png, normal_01.png and so on, it writes the Image FOLDER/normal.res. docs/how-to/godot.md uses it.
extends SceneTree

const FIRST := "_00.png"


func _init():
	var words := Array(OS.get_cmdline_args())
	var folder: String = words.back() if not words.empty() else ""
	var directory := Directory.new()
	if directory.open(folder) != OK:
		fail("%s: is not a folder; expected the output of multum export --for godot --format png" % folder)
		return
	var count := 0
	directory.list_dir_begin(true, true)
	var name := directory.get_next()
	while name != "":
		if name.ends_with(FIRST):
			var stem: String = folder.plus_file(name.substr(0, name.length() - FIRST.length()))
			if not join_levels(stem):
				return
			count += 1
		name = directory.get_next()
	if count == 0:
		fail("%s: has no file NAME%s; expected the output of multum export --for godot --format png" % [folder, FIRST])
		return
	quit()


func fail(text: String):
	printerr("godot3_levels: " + text)
	quit(1)


func join_levels(stem: String) -> bool:
	var width := 0
	var height := 0
	var level := 0
	var bytes := PoolByteArray()
	while level == 0 or max(width >> (level - 1), height >> (level - 1)) > 1:
		var path := "%s_%02d.png" % [stem, level]
		var image := Image.new()
		if image.load(path) != OK:
			fail("%s: cannot be read; expected all levels down to 1 x 1" % path)
			return false
		image.convert(Image.FORMAT_RGB8)
		if level == 0:
			width = image.get_width()
			height = image.get_height()
		var expected := Vector2(max(1, width >> level), max(1, height >> level))
		if image.get_size() != expected:
			fail("%s: has %s texels, expected %s" % [path, image.get_size(), expected])
			return false
		bytes.append_array(image.get_data())
		level += 1
	var joined := Image.new()
	joined.create_from_data(width, height, true, Image.FORMAT_RGB8, bytes)
	var result := ResourceSaver.save(stem + ".res", joined)
	if result != OK:
		fail("%s.res: cannot be written (error %d)" % [stem, result])
		return false
	print("%s.res: %d levels of %d x %d" % [stem, level, width, height])
	return true
