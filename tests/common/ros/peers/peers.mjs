// Other people's readers and writers of ROS 2's CDR and of MCAP:
//   node peers.mjs cdr IN OUT       [{type, cdr, value}] to [{difference, cdr}]: decodes, compares, encodes again
//   node peers.mjs hash IN OUT      [{type, schema}] to the hashes that ROS compares (REP-2011, "RIHS01_")
//   node peers.mjs read FILE OUT    every message of an MCAP file, by the indexed and the streaming reader
//   node peers.mjs write FILE KIND  an MCAP file of 60 messages on three channels
import { crc32 } from "@foxglove/crc";
import { parse } from "@foxglove/rosmsg";
import { ros2humble, ros2jazzy } from "@foxglove/rosmsg-msgs-common";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import lz4 from "lz4js";
import { createHash } from "node:crypto";
import { open, readFile, writeFile } from "node:fs/promises";

function definitionsOf(distribution, type) {
  const name = type.replace("/msg/", "/");
  return [{ definitions: distribution[name].definitions }, ...Object.values(distribution)];
}

// The first place at which two values differ; nothing when they do not.
function difference(a, b, place = "message") {
  if (ArrayBuffer.isView(a)) a = Array.from(a);
  if (Array.isArray(a) || Array.isArray(b)) {
    if (a?.length !== b?.length) return `${place}: ${a?.length} and ${b?.length} elements`;
    for (let i = 0; i < a.length; ++i) {
      const found = difference(a[i], b[i], `${place}[${i}]`);
      if (found) return found;
    }
    return undefined;
  }
  if (typeof a === "object" && a !== null) {
    for (const key of new Set([...Object.keys(a), ...Object.keys(b)])) {
      const found = difference(a[key], b[key], `${place}.${key}`);
      if (found) return found;
    }
    return undefined;
  }
  return a === b ? undefined : `${place}: ${a} and ${b}`;
}

async function cdr(input, output) {
  const answers = [];
  for (const one of JSON.parse(await readFile(input))) {
    const bytes = new Uint8Array(Buffer.from(one.cdr, "base64"));
    const schema = parse(one.schema, { ros2: true });
    let found;
    for (const definitions of [definitionsOf(ros2jazzy, one.type), definitionsOf(ros2humble, one.type), schema]) {
      found ??= difference(new MessageReader(definitions).readMessage(bytes), one.value);
    }
    const again = new MessageWriter(definitionsOf(ros2jazzy, one.type)).writeMessage(one.value);
    answers.push({ difference: found ?? "", cdr: Buffer.from(again).toString("base64") });
  }
  await writeFile(output, JSON.stringify(answers));
}

// Numbers of type_description_interfaces/msg/FieldType; an array has 48 more, a sequence 144.
const TYPE_IDS = {
  int8: 2, uint8: 3, int16: 4, uint16: 5, int32: 6, uint32: 7, int64: 8, uint64: 9, float32: 10, float64: 11,
  bool: 15, byte: 16, char: 3, string: 17,
};

function fieldOf(line) {
  const [, type, bounded, array, length, name] = /^([\w/]+)(?:<=(\d+))?(\[(\d*)\])?\s+(\w+)/.exec(line);
  const id = (bounded ? 21 : TYPE_IDS[type] ?? 1) + (array ? (length ? 48 : 144) : 0);
  return { name, type: {
    type_id: id, capacity: Number(length || 0), string_capacity: Number(bounded || 0),
    nested_type_name: type in TYPE_IDS ? "" : type.replace("/", "/msg/"),
  } };
}

// Of a schema as rosbag2 stores it.
function hashOf(type, schema) {
  const [first, ...others] = schema.split(/^=+\n/m);
  const describe = (name, text) => ({
    type_name: name,
    fields: text.split("\n").filter((line) => line && !line.includes("=") || line.includes("<=")).map(fieldOf),
  });
  const references = others.map((text) => {
    const [, name, body] = /^MSG: (\S+)\n([^]*)$/.exec(text);
    return describe(name.replace("/", "/msg/"), body);
  });
  references.sort((a, b) => (a.type_name < b.type_name ? -1 : 1));
  const description = { type_description: describe(type, first), referenced_type_descriptions: references };
  // As Python's json.dumps() writes it; names have neither quotes nor these characters.
  const json = JSON.stringify(description).replaceAll(",", ", ").replaceAll('":', '": ');
  return "RIHS01_" + createHash("sha256").update(json).digest("hex");
}

async function hash(input, output) {
  const types = JSON.parse(await readFile(input));
  // What ROS's own documents say of std_msgs/msg/String.
  const known = hashOf("std_msgs/msg/String", "string data\n");
  if (!known.startsWith("RIHS01_df668c740482bbd4")) throw new Error(`String has ${known}`);
  await writeFile(output, JSON.stringify(types.map((one) => hashOf(one.type, one.schema))));
}

function row(message, channel, schema) {
  return [channel.topic, schema?.name ?? "", Number(message.logTime), message.sequence, message.data.length,
    crc32(message.data)];
}

async function read(path, output) {
  const decompressHandlers = await loadDecompressHandlers();
  const file = await open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      await file.read(bytes, 0, Number(size), Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const indexed = [];
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    indexed.push(row(message, channel, reader.schemasById.get(channel.schemaId)));
  }
  const metadata = {};
  for await (const one of reader.readMetadata()) metadata[one.name] = Object.fromEntries(one.metadata);

  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const streamed = [];
  const channels = new Map();
  const schemas = new Map();
  let dataCrc;
  const bytes = await readFile(path);
  for (let at = 0; at < bytes.length; at += 100_003) {
    stream.append(bytes.subarray(at, at + 100_003));
    for (let record; (record = stream.nextRecord()); ) {
      if (record.type === "Channel") channels.set(record.id, record);
      if (record.type === "Schema") schemas.set(record.id, record);
      if (record.type === "DataEnd") dataCrc = record.dataSectionCrc;
      if (record.type !== "Message") continue;
      const channel = channels.get(record.channelId);
      streamed.push(row(record, channel, schemas.get(channel.schemaId)));
    }
  }
  await writeFile(output, JSON.stringify({
    indexed, streamed, metadata,
    done: stream.done(),
    dataCrc,
    statistics: {
      messages: Number(reader.statistics.messageCount),
      channels: reader.statistics.channelCount,
      chunks: reader.statistics.chunkCount,
      counts: Object.fromEntries(Array.from(reader.statistics.channelMessageCounts, ([id, n]) =>
        [reader.channelsById.get(id).topic, Number(n)])),
    },
  }));
}

async function write(path, kind) {
  await zstd.isLoaded;
  const file = await open(path, "w");
  let position = 0n;
  const writable = {
    position: () => position,
    write: async (bytes) => {
      await file.write(bytes);
      position += BigInt(bytes.byteLength);
    },
  };
  const compress = {
    zstd: (bytes) => ({ compression: "zstd", compressedData: zstd.compress(bytes, 1) }),
    lz4: (bytes) => ({ compression: "lz4", compressedData: lz4.compress(bytes) }),
  };
  const bare = kind === "bare";
  const writer = new McapWriter({
    writable,
    useChunks: kind !== "unchunked" && !bare,
    chunkSize: 3000,
    compressChunk: compress[kind],
    ...(bare && {
      useStatistics: false, useSummaryOffsets: false, repeatChannels: false, repeatSchemas: false,
      useChunkIndex: false, useMessageIndex: false, useMetadataIndex: false,
    }),
  });
  await writer.start({ profile: "ros2", library: "peer" });
  const schemaId = await writer.registerSchema({
    name: "std_msgs/msg/String", encoding: "ros2msg", data: new TextEncoder().encode("string data"),
  });
  const ids = [];
  for (const topic of ["/a", "/b", "/none"]) {
    ids.push(await writer.registerChannel({
      topic, schemaId: topic === "/none" ? 0 : schemaId, messageEncoding: "cdr", metadata: new Map([["of", topic]]),
    }));
  }
  await writer.addMetadata({ name: "who", metadata: new Map([["wrote", "peer"]]) });
  for (let i = 0; i < 60; ++i) {
    const data = new Uint8Array(37 * i).map((_, k) => (i * 7 + k * (k % 3)) % 256);
    await writer.addMessage({
      channelId: ids[i % 3], sequence: i, logTime: BigInt(1000 + i), publishTime: BigInt(500 + i), data,
    });
  }
  await writer.end();
  await file.close();
}

const [command, ...rest] = process.argv.slice(2);
await { cdr, hash, read, write }[command](...rest);
