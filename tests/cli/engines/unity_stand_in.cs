// SPDX-License-Identifier: Apache-2.0
// Stands in for the part of Unity that tools/engines/MultumImporter.cs uses. The names follow Unity's documentation.
// The program imports one file, and prints and stores what Unity would receive.
using System;
using System.IO;
using UnityEditor;
using UnityEngine;

namespace UnityEngine
{
    public class Object { public string name; }
    public class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    public class RangeAttribute : Attribute { public RangeAttribute(float least, float most) { } }
    public enum TextureWrapMode { Repeat }
    public enum FilterMode { Trilinear }
    public enum TextureFormat { RGBAHalf, RGBA32, RG16, R8, BC5, BC7 }

    public class Texture2D : Object
    {
        public TextureFormat format;
        public TextureWrapMode wrapMode;
        public FilterMode filterMode;
        public int anisoLevel, width, height, mipmapCount;
        public bool isLinear;
        public byte[] data;

        public Texture2D(int width, int height, TextureFormat format, int mipCount, bool linear)
        {
            this.width = width;
            this.height = height;
            this.format = format;
            mipmapCount = mipCount;
            isLinear = linear;
        }
        public void LoadRawTextureData(byte[] bytes) { data = bytes; }
        public void Apply(bool updateMipmaps, bool makeNoLongerReadable)
        {
            if (updateMipmaps) throw new Exception("Unity would replace the stored levels");
        }
    }
}

namespace UnityEditor
{
    public enum TextureCompressionQuality { Best }
    public static class EditorUtility
    {
        public static void CompressTexture(Texture2D texture, TextureFormat format, TextureCompressionQuality quality)
        {
            texture.format = format;
            Console.WriteLine("compressed " + format);
        }
    }
    public class MenuItem : Attribute { public MenuItem(string path) { } }
    public static class Selection { public static string[] assetGUIDs = new string[0]; }
    public static class AssetDatabase
    {
        public static string GUIDToAssetPath(string guid) { return guid; }
        public static void SetImporterOverride<Importer>(string path) { }
    }
}

namespace UnityEditor.AssetImporters
{
    public class ScriptedImporterAttribute : Attribute
    {
        public ScriptedImporterAttribute(int version, string[] extensions, string[] overrideExtensions) { }
    }
    public abstract class ScriptedImporter { public abstract void OnImportAsset(AssetImportContext context); }
    public class AssetImportContext
    {
        public string assetPath;
        public Texture2D texture;
        public void AddObjectToAsset(string name, UnityEngine.Object made, Texture2D thumbnail) { texture = thumbnail; }
        public void SetMainObject(UnityEngine.Object made) { }
        public void LogImportError(string text) { Console.WriteLine(text); }
        public void LogImportWarning(string text) { Console.WriteLine(text); }
    }

    public static class Program
    {
        public static void Main(string[] words)
        {
            var importer = new Multum.MultumImporter();
            importer.storage = (Multum.MultumImporter.Storage)Enum.Parse(typeof(Multum.MultumImporter.Storage), words[1]);
            var context = new AssetImportContext { assetPath = words[0] };
            importer.OnImportAsset(context);
            Texture2D made = context.texture;
            if (made == null) return;
            Console.WriteLine(made.name + " " + made.format + " " + made.width + " " + made.height + " " +
                              made.mipmapCount + (made.isLinear ? " linear" : " sRGB"));
            File.WriteAllBytes(words[2], made.data);
        }
    }
}
