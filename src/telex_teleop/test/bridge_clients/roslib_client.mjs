/**
 * An acceptance client: uses npm's roslib in both of its generations, and tells the outcome.
 *
 *     node roslib_client.mjs (1|2) URL
 *
 * Prints a JSON object: what came of each step.
 */
const TIMEOUT = 30000; // ms for one step
const [generation, url] = process.argv.slice(2);
const loaded = await import(`roslib-${generation}`);
const ROSLIB = loaded.default ?? loaded;
const name = `roslib_${generation}`;

const connect = () => new Promise((resolve, reject) => {
  const ros = new ROSLIB.Ros({ url });
  ros.on("connection", () => resolve(ros));
  ros.on("error", reject);
});
/** Ask one of the methods of Ros that take a callback for the answer and one for a failure. */
const ask = (ros, method, ...args) =>
  new Promise((resolve, reject) => ros[method](...args, resolve, reject));
const request = (fields) => (generation === "1" ? new ROSLIB.ServiceRequest(fields) : fields);
const message = (fields) => (generation === "1" ? new ROSLIB.Message(fields) : fields);

async function topic(ros) {
  const options = { ros, name: `/${name}/chat`, messageType: "std_msgs/String" };
  const heard = [];
  const listener = new ROSLIB.Topic(options);
  const done = new Promise((resolve) => listener.subscribe(({ data }) => {
    heard.push(data);
    if (heard.length === 3) resolve();
  }));
  await ask(ros, "getTopics"); // answered after the subscription has been made
  const talker = new ROSLIB.Topic(options);
  talker.advertise();
  for (const data of ["one", "two", "three"]) talker.publish(message({ data }));
  await done;
  listener.unsubscribe();
  talker.unadvertise();
  return heard;
}

/** Each compression of rosbridge, with what is lost or bent easily: NaN, bytes, long texts, arrays. */
async function compressed(ros) {
  const heard = {};
  for (const compression of ["png", "cbor"]) {
    const listener = new ROSLIB.Topic({
      ros, name: "/compressible", messageType: "sensor_msgs/JointState", compression,
    });
    const { name: names, position, header } = await new Promise((resolve) => listener.subscribe(resolve));
    listener.unsubscribe();
    heard[compression] = [names, Array.from(position, (each) => (Number.isNaN(each) ? null : each)), header.frame_id];
  }
  return heard;
}

function call(ros, service, fields) {
  const client = new ROSLIB.Service({ ros, name: service, serviceType: "std_srvs/SetBool" });
  return new Promise((resolve, reject) => client.callService(request(fields), resolve, reject));
}

async function service(ros) {
  const answer = await call(ros, "/lamp", { data: true });
  const refused = await call(ros, "/no_lamp", { data: true }).catch((error) => error);
  return [{ ...answer }, String(refused)];
}

async function offeredService(ros) {
  const options = { ros, name: `/${name}/switch`, serviceType: "std_srvs/SetBool" };
  const server = new ROSLIB.Service(options);
  server.advertise(({ data }, response) => {
    response.success = !data;
    response.message = name;
    return true;
  });
  while (!(await ask(ros, "getServices")).includes(options.name)) {
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  const answer = await call(await connect(), options.name, { data: false });
  server.unadvertise();
  return { ...answer };
}

/** As roslibjs's own tests do: no pause between offering, calling and withdrawing. */
async function hurriedService(ros) {
  const options = { ros, name: `/${name}/hurried`, serviceType: "std_srvs/SetBool" };
  let answered = 0;
  for (let round = 0; round < 10; round += 1) {
    const server = new ROSLIB.Service(options);
    await server.advertise((_, response) => {
      response.success = true;
      return true;
    });
    if ((await call(ros, options.name, { data: false })).success) answered += 1;
    await server.unadvertise();
  }
  return answered;
}

/** By the action and, where the client knows it, by the service. */
async function transforms(ros) {
  const heard = [];
  for (const groovyCompatibility of generation === "1" ? [true, false] : [true]) {
    const client = new ROSLIB.TFClient({
      ros, fixedFrame: "/odom", angularThres: 0.01, transThres: 0.01, rate: 20, groovyCompatibility,
    });
    let count = 0;
    const { translation } = await new Promise((resolve) => client.subscribe("/arm", (transform) => {
      count += 1;
      resolve(transform);
    }));
    await new Promise((resolve) => setTimeout(resolve, 300));
    heard.push([translation.x, translation.z, count]);
    client.dispose?.();
  }
  return heard;
}

async function parameter(ros) {
  const param = new ROSLIB.Param({ ros, name: `/${name}/limits` });
  await new Promise((resolve) => param.set({ speed: 1.5 }, resolve));
  const value = await new Promise((resolve) => param.get(resolve));
  await new Promise((resolve) => param.delete(resolve));
  return [value, await new Promise((resolve) => param.get(resolve))];
}

async function graph(ros) {
  const details = await ask(ros, "getMessageDetails", "geometry_msgs/Twist");
  const decoded = ros.decodeTypeDefs(details);
  const raw = await ask(ros, "getTopicsAndRawTypes");
  const index = raw.topics.indexOf("/telex/bridge/clients");
  return {
    topic_type: await ask(ros, "getTopicType", "/telex/bridge/clients"),
    topics_for_type: await ask(ros, "getTopicsForType", "telex_msgs/BridgeClients"),
    service: (await ask(ros, "getServices")).includes("/lamp"),
    service_type: await ask(ros, "getServiceType", "/lamp"),
    services_for_type: await ask(ros, "getServicesForType", "std_srvs/SetBool"),
    node: (await ask(ros, "getNodes")).includes("/telex/rosbridge"),
    request: (await ask(ros, "getServiceRequestDetails", "std_srvs/SetBool")).typedefs[0].fieldnames,
    twist: Object.keys(decoded),
    raw: raw.typedefs_full_text[index].includes("BridgeClient[] clients"),
    parameter: (await ask(ros, "getParams")).includes("/run_id"),
    action_server: (await ask(ros, "getActionServers")).includes(`/${name}/flippers`),
  };
}

async function action(ros) {
  const Client = ROSLIB.ActionClient;
  const client = new Client({
    ros, serverName: `/${name}/flippers`, actionName: "telex_msgs/FlipperPresetAction",
  });
  const goal = new ROSLIB.Goal({ actionClient: client, goalMessage: { preset: name } });
  let feedback = 0;
  goal.on("feedback", () => { feedback += 1; });
  const result = await new Promise((resolve) => {
    goal.on("result", resolve);
    goal.send();
  });
  return [feedback > 0, result.message];
}

const ros = await connect();
const outcome = {};
for (const step of [topic, compressed, service, offeredService, hurriedService, transforms, parameter, graph, action]) {
  const late = new Promise((_, reject) => setTimeout(reject, TIMEOUT, new Error(`${step.name} hangs`)));
  outcome[step.name] = await Promise.race([step(ros), late]);
}
console.log(JSON.stringify(outcome));
process.exit(0);
