// SPDX-License-Identifier: Apache-2.0
// Imports the DDS files of `multum export --for unity` and `--for unity-hdrp` into Unity, and keeps the stored mip
// levels. Copy this file to an Editor folder of the project. Then select the files, and choose
// Assets > multum > Import with stored mips. Needs Unity 2020.2 or later. It has not been run, because Unity was not at
// hand. docs/how-to/unity.md describes the import without this script.
using System;
using System.IO;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;

namespace Multum
{
    [ScriptedImporter(1, new string[] { "mdds" }, new string[] { "dds" })]
    public sealed class MultumImporter : ScriptedImporter
    {
        public enum Storage { AsInFile, BC5, BC7 }

        [Tooltip("Compress each stored level: BC5 for normals, BC7 for masks.")]
        public Storage storage = Storage.AsInFile;
        public TextureWrapMode wrapMode = TextureWrapMode.Repeat;
        public FilterMode filterMode = FilterMode.Trilinear;
        [Range(1, 16)] public int anisoLevel = 8;

        private const int kHead = 148;  // "DDS ", a header of 124 bytes, and the DX10 header of 20 bytes
        private const uint kDds = 0x20534444, kDx10 = 0x30315844;

        public override void OnImportAsset(AssetImportContext context)
        {
            try
            {
                Texture2D texture = Read(File.ReadAllBytes(context.assetPath));
                texture.name = Path.GetFileNameWithoutExtension(context.assetPath);
                if (storage != Storage.AsInFile) Compress(texture, context);
                texture.Apply(false, true);
                context.AddObjectToAsset("texture", texture, texture);
                context.SetMainObject(texture);
            }
            catch (InvalidDataException error)
            {
                context.LogImportError(context.assetPath + ": " + error.Message);
            }
        }

        private Texture2D Read(byte[] file)
        {
            if (file.Length < kHead || Number(file, 0) != kDds || Number(file, 84) != kDx10)
                throw new InvalidDataException("is not a DDS file with a DX10 header, expected a file of multum export");
            int height = (int)Number(file, 12), width = (int)Number(file, 16), levels = (int)Number(file, 28);
            uint format = Number(file, 128);
            if (width < 1 || height < 1 || width > 16384 || height > 16384 || levels < 1 || levels > 15)
                throw new InvalidDataException("found " + width + " x " + height + " texels and " + levels +
                                               " levels, expected at most 16384 x 16384 and 15");
            int texelBytes = BytesOf(format);
            if (texelBytes == 0)
                throw new InvalidDataException("found the DXGI format " + format + ", expected an export with --texels " +
                                               "rgba8 or rgba16f; this script cannot turn compressed blocks around");
            long total = 0;
            for (int level = 0; level < levels; ++level)
                total += (long)Side(width, level) * Side(height, level) * texelBytes;
            if (file.Length < kHead + total)
                throw new InvalidDataException("has " + file.Length + " bytes, expected " + (kHead + total));
            byte[] rows = new byte[total];
            int at = 0;
            for (int level = 0; level < levels; ++level)
            {
                // The first row of a DDS file is the top row. The first row of a texture in Unity is the bottom row.
                int pitch = Side(width, level) * texelBytes, count = Side(height, level);
                for (int row = 0; row < count; ++row)
                    Buffer.BlockCopy(file, kHead + at + row * pitch, rows, at + (count - 1 - row) * pitch, pitch);
                at += pitch * count;
            }
            // The last argument makes the texture linear: normals, roughness and masks are no colours.
            var texture = new Texture2D(width, height, UnityFormat(format), levels, true);
            texture.wrapMode = wrapMode;
            texture.filterMode = filterMode;
            texture.anisoLevel = anisoLevel;
            texture.LoadRawTextureData(rows);
            texture.Apply(false, false);  // the first argument keeps the stored levels
            return texture;
        }

        private void Compress(Texture2D texture, AssetImportContext context)
        {
            TextureFormat wanted = storage == Storage.BC5 ? TextureFormat.BC5 : TextureFormat.BC7;
            int levels = texture.mipmapCount;
            EditorUtility.CompressTexture(texture, wanted, TextureCompressionQuality.Best);
            if (texture.format != wanted || texture.mipmapCount != levels)
                context.LogImportWarning(context.assetPath + ": Unity did not compress all levels as " + wanted);
        }

        private static int BytesOf(uint format)
        {
            return format == 10 ? 8 : format == 28 ? 4 : format == 49 ? 2 : format == 61 ? 1 : 0;
        }

        // DXGI_FORMAT: 10 R16G16B16A16_FLOAT, 28 R8G8B8A8_UNORM, 49 R8G8_UNORM, 61 R8_UNORM.
        private static TextureFormat UnityFormat(uint format)
        {
            return format == 10 ? TextureFormat.RGBAHalf
                : format == 28 ? TextureFormat.RGBA32
                : format == 49 ? TextureFormat.RG16 : TextureFormat.R8;
        }

        private static int Side(int side, int level) { return Math.Max(1, side >> level); }

        private static uint Number(byte[] file, int at) { return BitConverter.ToUInt32(file, at); }

        [MenuItem("Assets/multum/Import with stored mips")]
        private static void ImportSelected()
        {
            foreach (string guid in Selection.assetGUIDs)
            {
                string path = AssetDatabase.GUIDToAssetPath(guid);
                if (path.EndsWith(".dds", StringComparison.OrdinalIgnoreCase))
                    AssetDatabase.SetImporterOverride<MultumImporter>(path);
            }
        }
    }
}
